#include "rendering/raster/device_projection.h"

#include <algorithm>
#include <string>
#include <vector>

#include "rendering/gl/layout.h"
#include "rendering/shader_sources.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostGroups = 512;  // of PROJECT_GROUP tetrahedra in a batch: 25 to 63 MB of vertices

}  // namespace

DeviceProjection::DeviceProjection(const GlFunctions& gl, std::uint64_t largest_buffer)
    : gl_(gl), largest_buffer_(largest_buffer) {}

bool DeviceProjection::works(const GlFunctions& gl) {
  GLint blocks = 0, bindings = 0;
  gl.GetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &blocks);
  gl.GetIntegerv(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, &bindings);
  return blocks > BUFFER_SHADES && bindings > BUFFER_SHADES;
}

std::uint64_t DeviceProjection::Variant::vertex_words() const {
  return shaded ? SHADED_VERTEX_WORDS : linear ? LINEAR_VERTEX_WORDS : VERTEX_WORDS;
}

bool DeviceProjection::reserve(GlObject& buffer, std::uint64_t& held, std::uint64_t bytes, GLbitfield flags) {
  bytes = std::max<std::uint64_t>(bytes, 16);
  if (buffer && held >= bytes) return true;
  buffer = GlObject{};
  held = 0;
  if (bytes > largest_buffer_) return false;
  bytes = std::min(largest_buffer_, bytes + bytes / 4);  // the next frame may have a little more
  buffer = make_buffer(gl_);
  gl_.NamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(bytes), nullptr, flags);
  if (gl_.GetError() != GL_NO_ERROR) {
    buffer = GlObject{};
    return false;
  }
  held = bytes;
  return true;
}

bool DeviceProjection::prepare(const Variant& variant, std::span<const std::uint32_t> order,
                               std::span<const std::uint32_t> parts) {
  variant_ = variant;
  count_ = order.size();
  if (!reserve(order_, order_bytes_, order.size_bytes(), GL_DYNAMIC_STORAGE_BIT) ||
      !reserve(parts_, parts_bytes_, parts.size_bytes(), GL_DYNAMIC_STORAGE_BIT))
    return false;
  if (!order.empty()) gl_.NamedBufferSubData(order_.name(), 0, static_cast<GLsizeiptr>(order.size_bytes()), order.data());
  if (!parts.empty()) gl_.NamedBufferSubData(parts_.name(), 0, static_cast<GLsizeiptr>(parts.size_bytes()), parts.data());
  const std::uint64_t vertices = PROJECTED_VERTICES + (variant.surfaces ? FACET_VERTICES : 0);
  const std::uint64_t groups = std::min((count_ + PROJECT_GROUP - 1) / PROJECT_GROUP, kMostGroups);
  for (Batch& batch : batches_) {
    if (!reserve(batch.vertices, batch.bytes, groups * PROJECT_GROUP * vertices * variant.vertex_words() * 4, 0)) return false;
    if (batch.commands) continue;
    batch.commands = make_buffer(gl_);
    const std::vector<shaders::DrawCommand> none(kMostGroups, shaders::DrawCommand{});  // drawn if a dispatch never ran
    gl_.NamedBufferStorage(batch.commands.name(), static_cast<GLsizeiptr>(none.size() * sizeof(shaders::DrawCommand)), none.data(), 0);
  }
  GlObject& program = programs_[variant];
  if (!program) {
    std::string defines;
    if (variant.linear) defines += "#define LINEAR_COLOR\n";
    if (variant.orthographic) defines += "#define ORTHOGRAPHIC\n";
    if (variant.surfaces) defines += "#define SURFACES\n";
    if (variant.shaded) defines += "#define BODY_SHADING\n";
    program = make_compute_program(gl_, shaders::frame_glsl, shaders::project_tetrahedra_comp, defines);
  }
  return gl_.GetError() == GL_NO_ERROR;
}

void DeviceProjection::draw(GLuint drawing_program, GLuint vertex_array) {
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BUFFER_DRAWN_ORDER, order_.name());
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BUFFER_DRAWN_PARTS, parts_.name());
  const GLuint program = programs_.at(variant_).name();
  const auto stride = static_cast<GLsizei>(4 * variant_.vertex_words());
  std::size_t turn = 0;
  for (std::size_t first = 0; first < count_; first += kMostGroups * PROJECT_GROUP, ++turn) {
    const Batch& batch = batches_[turn % 2];
    const std::size_t in_batch = std::min(count_ - first, kMostGroups * PROJECT_GROUP);
    const auto groups = static_cast<GLuint>((in_batch + PROJECT_GROUP - 1) / PROJECT_GROUP);
    gl_.UseProgram(program);
    gl_.ProgramUniform4ui(program, UNIFORM_BATCH, static_cast<GLuint>(first), static_cast<GLuint>(in_batch), 0, 0);
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BUFFER_VERTICES, batch.vertices.name());
    gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BUFFER_COMMANDS, batch.commands.name());
    gl_.DispatchCompute(groups, 1, 1);
    gl_.MemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
    gl_.UseProgram(drawing_program);
    gl_.BindVertexArray(vertex_array);
    gl_.VertexArrayVertexBuffer(vertex_array, 0, batch.vertices.name(), 0, stride);
    gl_.BindBuffer(GL_DRAW_INDIRECT_BUFFER, batch.commands.name());
    gl_.MultiDrawArraysIndirect(GL_TRIANGLES, nullptr, static_cast<GLsizei>(groups), 0);
  }
}

}  // namespace isostrata
