#include "rendering/gl_renderer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "base/stopwatch.h"
#include "rendering/check_draw_input.h"
#include "rendering/draw_groups.h"
#include "rendering/draw_target.h"
#include "rendering/gl_objects.h"
#include "rendering/projected_tetrahedra.h"
#include "rendering/shader_sources.h"
#include "rendering/shaders/layout.h"
#include "rendering/style_table.h"
#include "rendering/vertex_stream.h"

namespace isostrata {
namespace {

constexpr int kLargestTile = 4096;              // pixels; a float target of 268 MB
constexpr std::int64_t kBlock = 2048;           // tetrahedra emitted by one piece of work
constexpr std::int64_t kChunk = 32 * kBlock;    // tetrahedra emitted before they are drawn
constexpr std::size_t kRegionBytes = 12 << 20;  // of vertices drawn at once

/// Everything that lives in one context.
class GlState {
 public:
  explicit GlState(std::unique_ptr<GlContext> context);
  ~GlState() {
    try {
      context_->make_current();  // the objects are deleted in their own context
    } catch (const Error&) {
      // a lost context: the driver has dropped them already
    }
  }

  DrawResult draw(const DrawInput& input);
  const GlContext& context() const { return *context_; }

 private:
  GLuint program(bool linear, bool nearest);
  void draw_tile(const Tile& tile, const DrawInput& input, const Projection& projection, std::span<const ScreenPoint> points,
                 std::span<const std::uint32_t> order, bool linear, bool nearest);
  template <class Vertex>
  void draw_tetrahedra(const TetrahedraSource& source, std::span<const std::uint32_t> order,
                       std::array<std::vector<Vertex>, kChunk / kBlock>& blocks);
  void check_device();

  std::unique_ptr<GlContext> context_;
  const GlFunctions& gl_;
  int largest_tile_ = kLargestTile;
  std::map<std::pair<bool, bool>, GlObject> programs_;  // (linear, nearest)
  GlObject vertex_array_;
  std::optional<VertexStream> stream_;
  StyleTable styles_;
  DrawTarget target_;
  std::array<std::vector<ConstantVertex>, kChunk / kBlock> constant_blocks_;
  std::array<std::vector<LinearVertex>, kChunk / kBlock> linear_blocks_;
};

GlState::GlState(std::unique_ptr<GlContext> context)
    : context_(std::move(context)), gl_(context_->gl()), styles_(gl_), target_(gl_) {
  GLint largest = 0;
  gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  largest_tile_ = std::min(largest_tile_, static_cast<int>(largest));
  GLint viewport[2] = {0, 0};
  gl_.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  largest_tile_ = std::min({largest_tile_, static_cast<int>(viewport[0]), static_cast<int>(viewport[1])});

  vertex_array_ = make_vertex_array(gl_);
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
  gl_.VertexArrayAttribIFormat(array, ATTRIBUTE_STYLE, 1, GL_UNSIGNED_INT, offsetof(ConstantVertex, style_side));
  gl_.VertexArrayAttribBinding(array, ATTRIBUTE_STYLE, 0);
  // Only the linear program reads it; a LinearVertex has it behind a ConstantVertex.
  gl_.VertexArrayAttribFormat(array, ATTRIBUTE_SCALAR, 2, GL_FLOAT, GL_FALSE, sizeof(ConstantVertex));
  gl_.VertexArrayAttribBinding(array, ATTRIBUTE_SCALAR, 0);
  static_assert(sizeof(ConstantVertex) == 32 && sizeof(LinearVertex) == 40);

  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  check_device();
}

GLuint GlState::program(bool linear, bool nearest) {
  GlObject& program = programs_[{linear, nearest}];
  if (!program) {
    const std::string defines = std::string(linear ? "#define LINEAR_COLOR\n" : "") + (nearest ? "#define NEAREST_DEPTH\n" : "");
    program = make_program(gl_, shaders::tetrahedra_vert, shaders::tetrahedra_frag, defines);
  }
  return program.name();
}

template <class Vertex>
void GlState::draw_tetrahedra(const TetrahedraSource& source, std::span<const std::uint32_t> order,
                              std::array<std::vector<Vertex>, kChunk / kBlock>& blocks) {
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

void GlState::draw_tile(const Tile& tile, const DrawInput& input, const Projection& projection,
                        std::span<const ScreenPoint> points, std::span<const std::uint32_t> order, bool linear, bool nearest) {
  target_.begin(tile, nearest);
  styles_.bind();
  // The viewport is the guard's square about the middle of the picture; the framebuffer cuts the tile out of it.
  const int guard = projection.guard();
  const int viewport_x = input.width / 2 - guard - tile.x, viewport_y = input.height / 2 - guard - tile.y;
  gl_.Viewport(viewport_x, viewport_y, 2 * guard, 2 * guard);
  const GLuint program = this->program(linear, nearest);
  gl_.UseProgram(program);
  const double half_width = 0.5 * input.width, half_height = 0.5 * input.height;
  // Fragment (0.5, 0.5) of the tile is the middle of the picture's pixel (tile.x, tile.y).
  gl_.ProgramUniform4f(program, UNIFORM_CLIP_FROM_PIXELS, static_cast<float>(1.0 / guard), static_cast<float>(1.0 / guard),
                       static_cast<float>((half_width - tile.x - viewport_x) / guard - 1),
                       static_cast<float>((half_height - tile.y - viewport_y) / guard - 1));
  gl_.ProgramUniform4f(program, UNIFORM_RAY_FROM_FRAGMENT, static_cast<float>(1 / projection.focal),
                       static_cast<float>(1 / projection.focal), static_cast<float>((tile.x - half_width) / projection.focal),
                       static_cast<float>((tile.y - half_height) / projection.focal));
  gl_.Enable(GL_BLEND);
  gl_.BlendEquationi(0, GL_FUNC_ADD);
  gl_.BlendFunci(0, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (nearest) {
    gl_.BlendEquationi(1, GL_MAX);
    gl_.BlendFunci(1, GL_ONE, GL_ONE);
  }
  gl_.BindVertexArray(vertex_array_.name());
  const TetrahedraSource source{input.mesh.get(), input.color_values.get(), points, &projection};
  if (linear) {
    gl_.EnableVertexArrayAttrib(vertex_array_.name(), ATTRIBUTE_SCALAR);
    draw_tetrahedra(source, order, linear_blocks_);
  } else {
    gl_.DisableVertexArrayAttrib(vertex_array_.name(), ATTRIBUTE_SCALAR);
    draw_tetrahedra(source, order, constant_blocks_);
  }
  gl_.Disable(GL_BLEND);
}

void GlState::check_device() {
  if (gl_.GetGraphicsResetStatus && gl_.GetGraphicsResetStatus() != GL_NO_ERROR)
    throw Error(ErrorCode::unavailable, context_->device() + ": the driver has reset the device");
  const GLenum error = gl_.GetError();
  if (error == GL_OUT_OF_MEMORY) throw Error(ErrorCode::too_large, context_->device() + ": out of memory");
  if (error != GL_NO_ERROR) throw Error(ErrorCode::unavailable, context_->device() + ": OpenGL error " + std::to_string(error));
}

DrawResult GlState::draw(const DrawInput& input) {
  context_->make_current();
  DrawResult result;
  result.facts.renderer = "raster";
  result.facts.device = context_->device();

  Stopwatch watch;
  const VisibilityOrder order = order_groups(input);
  result.facts.order = order.method;
  result.facts.order_exact = order.exact;
  result.facts.tetrahedra = static_cast<std::int64_t>(order.tetrahedra.size());
  result.facts.order_ms = watch.lap_ms();

  bool linear = false;
  for (const IntervalStyle& style : input.styles) linear = linear || (style.visible && !style.color_map.empty());
  const Projection projection = make_projection(input.camera, input.bounds, input.width, input.height);
  const std::vector<ScreenPoint> points = project_points(*input.mesh, projection);
  styles_.set(input.styles, input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal()),
              projection.scale);
  const GlObject query = input.count_fragments ? make_query(gl_, GL_SAMPLES_PASSED) : GlObject{};

  const std::size_t pixels = static_cast<std::size_t>(input.width) * static_cast<std::size_t>(input.height);
  Image bytes;
  FloatImage floats;
  if (input.float_image)
    floats = {input.width, input.height, std::vector<float>(4 * pixels), std::vector<float>(pixels)};
  else
    bytes = {input.width, input.height, std::vector<std::uint8_t>(4 * pixels)};

  for (int y = 0; y < input.height; y += largest_tile_)
    for (int x = 0; x < input.width; x += largest_tile_) {
      const Tile tile{x, y, std::min(largest_tile_, input.width - x), std::min(largest_tile_, input.height - y)};
      if (query) gl_.BeginQuery(GL_SAMPLES_PASSED, query.name());
      draw_tile(tile, input, projection, points, order.tetrahedra, linear, input.float_image);
      if (query) {
        gl_.EndQuery(GL_SAMPLES_PASSED);
        GLuint64 passed = 0;
        gl_.GetQueryObjectui64v(query.name(), GL_QUERY_RESULT, &passed);
        result.facts.fragments += static_cast<std::int64_t>(passed);
      }
      if (!input.float_image) target_.resolve(input.background, input.transparent);
      gl_.Finish();
      result.facts.draw_ms += watch.lap_ms();
      if (input.float_image)
        target_.read(tile, projection.scale, floats);
      else
        target_.read(tile, bytes);
      result.facts.readback_ms += watch.lap_ms();
    }
  check_device();
  if (input.float_image)
    result.image = std::move(floats);
  else
    result.image = std::move(bytes);
  return result;
}

class GlRenderer : public Renderer {
 public:
  GlRenderer(std::unique_ptr<GlContext> context, std::string wanted) : wanted_(std::move(wanted)) {
    state_ = std::make_unique<GlState>(std::move(context));
    device_ = state_->context().device();
  }

  DrawResult draw(const DrawInput& input) override {
    check(input);
    if (!input.cut_intervals.empty())
      throw Error(ErrorCode::unavailable, "picture: intervals that the renderer cuts are drawn by the native renderer only");
    try {
      if (!state_) state_ = std::make_unique<GlState>(open_context(wanted_));
      return state_->draw(input);
    } catch (const std::bad_alloc&) {
      state_.reset();
      throw Error(ErrorCode::too_large,
                  "picture of " + std::to_string(input.width) + "x" + std::to_string(input.height) + ": out of memory");
    } catch (...) {
      state_.reset();  // whatever state the context is in, the next draw starts from a fresh one
      throw;
    }
  }

  const std::string& device() const override { return device_; }

 private:
  std::string wanted_, device_;
  std::unique_ptr<GlState> state_;
};

}  // namespace

std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, std::string device) {
  return std::make_unique<GlRenderer>(std::move(context), std::move(device));
}

}  // namespace isostrata
