#include "rendering/raster/gl_renderer.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "base/stopwatch.h"
#include "rendering/gl/draw_with_state.h"
#include "rendering/gl/gl_objects.h"
#include "rendering/gl/layout.h"
#include "rendering/order/draw_groups.h"
#include "rendering/picture/blank_picture.h"
#include "rendering/picture/body_shading.h"
#include "rendering/raster/device_mesh.h"
#include "rendering/raster/device_projection.h"
#include "rendering/raster/draw_target.h"
#include "rendering/raster/projected_tetrahedra.h"
#include "rendering/raster/raster_frame.h"
#include "rendering/raster/style_table.h"
#include "rendering/raster/vertex_stream.h"
#include "rendering/shader_sources.h"

namespace isostrata {
namespace {

constexpr int kLargestTile = 4096;              // pixels; a float target of 268 MB
constexpr std::int64_t kBlock = 2048;           // tetrahedra emitted by one piece of work
constexpr std::int64_t kChunk = 32 * kBlock;    // tetrahedra emitted before they are drawn
constexpr std::size_t kRegionBytes = 12 << 20;  // of vertices drawn at once

/// Everything that lives in one context.
class GlState {
 public:
  GlState(std::unique_ptr<GlContext> context, ProjectOn project_on);
  ~GlState() {
    try {
      context_->make_current();  // the objects are deleted in their own context
    } catch (const Error&) {
      // a lost context: the driver has dropped them already
    }
  }

  DrawResult draw(const DrawInput& input);
  void give_back() {
    mesh_.give_back();
    target_.give_back();
  }
  const GlContext& context() const { return *context_; }

 private:
  /// What the drawing program must know; each is compiled when first drawn with.
  struct Variant {
    bool linear, linear_extinction, table, orthographic, planes, surfaces, nearest, mean, shaded;
    bool wide = false;  // has what is projected on the device: KIND_WIDE
    auto operator<=>(const Variant&) const = default;
  };
  /// What is the same for all tiles of a frame.
  struct Frame {
    const DrawInput& input;
    Variant variant;
    Projection projection;
    std::vector<ScreenPoint> points;
    std::vector<std::uint32_t> order;  // tetrahedra, back to front
    std::vector<std::uint32_t> parts;  // [intervals]
    Buffer<float> shades;              // [np] where bodies are shaded
  };
  GLuint program(const Variant& variant);
  void prepare(Frame& frame);
  void draw_tile(const Tile& tile, const Frame& frame);
  template <class Vertex>
  void draw_tetrahedra(const Frame& frame, std::array<std::vector<Vertex>, kChunk / kBlock>& blocks);
  void check_device();

  std::unique_ptr<GlContext> context_;
  const GlFunctions& gl_;
  int largest_tile_ = kLargestTile;
  std::map<Variant, GlObject> programs_;
  GlObject vertex_array_, frame_block_, planes_;
  std::optional<VertexStream> stream_;
  StyleTable styles_;
  DrawTarget target_;
  DeviceMesh mesh_;
  DeviceProjection projection_;
  bool project_here_;  // on the device
  std::array<std::vector<ConstantVertex>, kChunk / kBlock> constant_blocks_;
  std::array<std::vector<LinearVertex>, kChunk / kBlock> linear_blocks_;
  std::array<std::vector<ShadedVertex>, kChunk / kBlock> shaded_blocks_;
};

GlState::GlState(std::unique_ptr<GlContext> context, ProjectOn project_on)
    : context_(std::move(context)),
      gl_(context_->gl()),
      styles_(gl_),
      target_(gl_),
      mesh_(gl_),
      projection_(gl_, mesh_.largest_buffer()),
      project_here_((project_on == ProjectOn::device || (project_on == ProjectOn::automatic && !context_->software())) &&
                    DeviceProjection::works(gl_)) {
  GLint largest = 0;
  gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  largest_tile_ = std::min(largest_tile_, static_cast<int>(largest));
  GLint viewport[2] = {0, 0};
  gl_.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  largest_tile_ = std::min({largest_tile_, static_cast<int>(viewport[0]), static_cast<int>(viewport[1])});

  vertex_array_ = make_vertex_array(gl_);
  frame_block_ = make_buffer(gl_);
  gl_.NamedBufferStorage(frame_block_.name(), sizeof(shaders::RasterFrame), nullptr, GL_DYNAMIC_STORAGE_BIT);
  stream_.emplace(gl_, kRegionBytes);

  const GLuint array = vertex_array_.name();
  const auto floats = [&](GLuint attribute, GLint count, std::size_t offset) {
    gl_.EnableVertexArrayAttrib(array, attribute);
    gl_.VertexArrayAttribFormat(array, attribute, count, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
    gl_.VertexArrayAttribBinding(array, attribute, 0);
  };
  floats(ATTRIBUTE_POSITION, 3, offsetof(ConstantVertex, x));
  floats(ATTRIBUTE_TENT, 3, offsetof(ConstantVertex, tent));
  floats(ATTRIBUTE_Q_MIN, 1, offsetof(ConstantVertex, q_min));
  gl_.EnableVertexArrayAttrib(array, ATTRIBUTE_STYLE);
  gl_.VertexArrayAttribIFormat(array, ATTRIBUTE_STYLE, 1, GL_UNSIGNED_INT, offsetof(ConstantVertex, style_kind));
  gl_.VertexArrayAttribBinding(array, ATTRIBUTE_STYLE, 0);
  gl_.EnableVertexArrayAttrib(array, ATTRIBUTE_ID);
  gl_.VertexArrayAttribIFormat(array, ATTRIBUTE_ID, 1, GL_UNSIGNED_INT, offsetof(ConstantVertex, tent));
  gl_.VertexArrayAttribBinding(array, ATTRIBUTE_ID, 0);
  // Only linear and shaded programs read these; a LinearVertex has its own behind a ConstantVertex, a ShadedVertex behind that.
  gl_.VertexArrayAttribFormat(array, ATTRIBUTE_SCALAR, 2, GL_FLOAT, GL_FALSE, sizeof(ConstantVertex));
  gl_.VertexArrayAttribBinding(array, ATTRIBUTE_SCALAR, 0);
  gl_.VertexArrayAttribFormat(array, ATTRIBUTE_SHADE, 2, GL_FLOAT, GL_FALSE, sizeof(LinearVertex));
  gl_.VertexArrayAttribBinding(array, ATTRIBUTE_SHADE, 0);
  static_assert(sizeof(ConstantVertex) == 32 && sizeof(LinearVertex) == 40);

  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  check_device();
}

GLuint GlState::program(const Variant& variant) {
  GlObject& program = programs_[variant];
  if (!program) {
    std::string defines;
    const auto define = [&](bool wanted, const char* name) {
      if (wanted) defines += std::string("#define ") + name + "\n";
    };
    define(variant.linear, "LINEAR_COLOR");
    define(variant.linear_extinction, "LINEAR_EXTINCTION");
    define(variant.table, "TABLE_2D");
    define(variant.orthographic, "ORTHOGRAPHIC");
    define(variant.planes, "CLIP_PLANES");
    define(variant.surfaces, "SURFACES");
    define(variant.nearest, "NEAREST_DEPTH");
    define(variant.mean, "MEAN_DEPTH");
    define(variant.wide, "WIDE");
    define(variant.shaded, "BODY_SHADING");
    const std::string vertex = std::string(shaders::frame_glsl) + shaders::tetrahedra_vert;
    const std::string fragment =
        std::string(shaders::frame_glsl) + shaders::optics_glsl + shaders::surface_shading_glsl + shaders::tetrahedra_frag;
    program = make_program(gl_, vertex.c_str(), fragment.c_str(), defines);
  }
  return program.name();
}

template <class Vertex>
void GlState::draw_tetrahedra(const Frame& frame, std::array<std::vector<Vertex>, kChunk / kBlock>& blocks) {
  const DrawInput& input = frame.input;
  const TetrahedraSource source{input.mesh.get(),
                                input.color_values.get(),
                                frame.points,
                                &frame.projection,
                                frame.variant.surfaces && !mesh_.facets().first_of.empty() ? &mesh_.facets() : nullptr,
                                frame.parts,
                                frame.shades};
  const std::span<const std::uint32_t> order = frame.order;
  const VertexStream::Draw draw = [&](std::size_t offset, std::int32_t vertices) {
    gl_.VertexArrayVertexBuffer(vertex_array_.name(), 0, stream_->buffer(), static_cast<GLintptr>(offset), sizeof(Vertex));
    gl_.DrawArrays(GL_TRIANGLES, 0, vertices);
  };
  for (std::size_t chunk = 0; chunk < order.size(); chunk += kChunk) {
    const auto in_chunk = order.subspan(chunk, std::min<std::size_t>(kChunk, order.size() - chunk));
    for (auto& block : blocks) block.clear();
    parallel_for(static_cast<std::int64_t>((in_chunk.size() + kBlock - 1) / kBlock), 1,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t b = begin; b < end; ++b) {
                     const auto first = static_cast<std::size_t>(b * kBlock);
                     emit_tetrahedra(source, in_chunk.subspan(first, std::min<std::size_t>(kBlock, in_chunk.size() - first)),
                                     blocks[static_cast<std::size_t>(b)]);
                   }
                 });
    for (const auto& block : blocks) stream_->write(std::as_bytes(std::span(block)), sizeof(Vertex), draw);
  }
  stream_->flush(sizeof(Vertex), draw);
}

void GlState::prepare(Frame& frame) {
  const DrawInput& input = frame.input;
  styles_.set(input.styles, input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal()),
              frame.projection.scale, frame.variant.table);
  if (frame.variant.surfaces) mesh_.set_facets(input, frame.projection.scale);
  if (frame.variant.shaded) frame.shades = body_shades(input);
  if (project_here_ && mesh_.set_mesh(input, frame.projection.scale) && (!frame.variant.shaded || mesh_.set_shades(frame.shades)))
    frame.variant.wide = projection_.prepare({frame.variant.linear, frame.variant.orthographic, frame.variant.surfaces, frame.variant.shaded},
                                             frame.order, frame.parts);
  if (!frame.variant.wide) frame.points = project_points(*input.mesh, frame.projection);
  if (frame.variant.planes) {
    const auto planes = view_planes(input, frame.projection);
    planes_ = make_buffer(gl_);
    gl_.NamedBufferStorage(planes_.name(), static_cast<GLsizeiptr>(planes.size() * sizeof planes[0]), planes.data(), 0);
  }
}

void GlState::draw_tile(const Tile& tile, const Frame& frame) {
  const DrawInput& input = frame.input;
  styles_.bind();
  mesh_.bind();
  // The viewport is the guard's square about the middle of the picture; the framebuffer cuts the tile out of it.
  const int guard = frame.projection.guard();
  const int viewport_x = input.width / 2 - guard - tile.x, viewport_y = input.height / 2 - guard - tile.y;
  gl_.Viewport(viewport_x, viewport_y, 2 * guard, 2 * guard);
  const shaders::RasterFrame block = raster_frame(input, frame.projection, tile, viewport_x, viewport_y);
  gl_.NamedBufferSubData(frame_block_.name(), 0, sizeof block, &block);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_FRAME, frame_block_.name());
  if (frame.variant.planes) gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, BUFFER_PLANES, planes_.name());
  gl_.UseProgram(program(frame.variant));
  gl_.Enable(GL_BLEND);
  gl_.BlendEquationi(0, GL_FUNC_ADD);
  gl_.BlendFunci(0, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (frame.variant.nearest) {
    gl_.BlendEquationi(1, GL_MAX);
    gl_.BlendFunci(1, GL_ONE, GL_ONE);
  }
  if (frame.variant.mean) {
    gl_.BlendEquationi(2, GL_FUNC_ADD);
    gl_.BlendFunci(2, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  }
  gl_.BindVertexArray(vertex_array_.name());
  const auto read = [&](GLuint attribute, bool wanted) {
    if (wanted)
      gl_.EnableVertexArrayAttrib(vertex_array_.name(), attribute);
    else
      gl_.DisableVertexArrayAttrib(vertex_array_.name(), attribute);
  };
  read(ATTRIBUTE_SCALAR, frame.variant.linear);
  read(ATTRIBUTE_SHADE, frame.variant.shaded);
  if (frame.variant.wide)
    projection_.draw(program(frame.variant), vertex_array_.name());
  else if (frame.variant.shaded)
    draw_tetrahedra(frame, shaded_blocks_);
  else if (frame.variant.linear)
    draw_tetrahedra(frame, linear_blocks_);
  else
    draw_tetrahedra(frame, constant_blocks_);
  gl_.Disable(GL_BLEND);
}

void GlState::check_device() {
  if (gl_.GetGraphicsResetStatus && gl_.GetGraphicsResetStatus() != GL_NO_ERROR)
    throw Error(ErrorCode::unavailable, context_->device() + ": the driver has reset the device");
  const GLenum error = gl_.GetError();
  if (error == GL_CONTEXT_LOST) throw Error(ErrorCode::unavailable, context_->device() + ": the context was lost");
  if (error == GL_OUT_OF_MEMORY) throw Error(ErrorCode::too_large, context_->device() + ": out of memory: narrow the intervals or draw with native");
  if (error != GL_NO_ERROR) throw Error(ErrorCode::unavailable, context_->device() + ": OpenGL error " + std::to_string(error));
}

DrawResult GlState::draw(const DrawInput& input) {
  context_->make_current();
  DrawResult result;
  result.facts.renderer = "raster";
  result.facts.device = context_->device();

  Stopwatch watch;
  VisibilityOrder order = order_groups(input);
  result.facts.order = order.method;
  result.facts.order_exact = order.exact;
  result.facts.tetrahedra = static_cast<std::int64_t>(order.tetrahedra.size());
  result.facts.order_ms = watch.lap_ms();

  bool linear = false, linear_extinction = false;
  for (const IntervalStyle& style : input.styles) {
    linear = linear || (style.visible && !style.constant());
    linear_extinction = linear_extinction || (style.visible && style.opacity_upper);
  }
  const Projection projection = make_projection(input);
  const Variant variant{linear,
                        linear_extinction,
                        linear && input.integral == Integral::table2d,
                        input.camera.orthographic,
                        !input.clip_planes.empty(),
                        draws_surfaces(input) && !input.mesh->facets.empty(),
                        input.float_image && !input.rounded,
                        input.float_image && input.mean_depth,
                        shades_bodies(input)};
  Frame frame{input, variant, projection, {}, std::move(order.tetrahedra), drawn_parts(input.styles), {}};
  prepare(frame);
  if (project_here_ && !frame.variant.wide)
    result.facts.device += ", its tetrahedra projected by the CPU: the device has no room for the mesh";
  const GlObject query = input.count_fragments ? make_query(gl_, GL_SAMPLES_PASSED) : GlObject{};

  result.image = blank_picture(input);
  auto* const floats = std::get_if<FloatImage>(&result.image);

  for (int y = 0; y < input.height; y += largest_tile_)
    for (int x = 0; x < input.width; x += largest_tile_) {
      const Tile tile{x, y, std::min(largest_tile_, input.width - x), std::min(largest_tile_, input.height - y)};
      target_.begin(tile, frame.variant.nearest, frame.variant.mean);
      if (query) gl_.BeginQuery(GL_SAMPLES_PASSED, query.name());
      draw_tile(tile, frame);
      if (query) {
        gl_.EndQuery(GL_SAMPLES_PASSED);
        GLuint64 passed = 0;
        gl_.GetQueryObjectui64v(query.name(), GL_QUERY_RESULT, &passed);
        result.facts.fragments += static_cast<std::int64_t>(passed);
      }
      if (!floats) target_.resolve(input.background, input.transparent);
      gl_.Finish();
      result.facts.draw_ms += watch.lap_ms();
      if (floats)
        target_.read(
            tile, [&](double q) { return projection.depth(q) * projection.scale; }, projection.scale, *floats);
      else
        target_.read(tile, std::get<Image>(result.image));
      result.facts.readback_ms += watch.lap_ms();
    }
  check_device();
  return result;
}

class GlRenderer : public Renderer {
 public:
  GlRenderer(std::unique_ptr<GlContext> context, std::string wanted, ProjectOn project_on)
      : wanted_(std::move(wanted)), project_on_(project_on) {
    state_ = std::make_unique<GlState>(std::move(context), project_on_);
    device_ = state_->context().device();
  }

  DrawResult draw(const DrawInput& input) override {
    if (input.bricks) throw Error(ErrorCode::invalid_argument, "picture: renderer raster cannot draw layers without a mesh");
    return draw_with_state(
        state_, [&] { return std::make_unique<GlState>(open_context(wanted_), project_on_); }, input);
  }

  const std::string& device() const override { return device_; }

 private:
  std::string wanted_, device_;
  const ProjectOn project_on_;
  std::unique_ptr<GlState> state_;
};

}  // namespace

std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, std::string device, ProjectOn project_on) {
  return std::make_unique<GlRenderer>(std::move(context), std::move(device), project_on);
}

}  // namespace isostrata
