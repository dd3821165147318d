#include "rendering/compute/gl_tiles.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "base/stopwatch.h"
#include "rendering/picture/pixel_grid.h"
#include "rendering/shader_sources.h"

namespace isostrata {
namespace {

constexpr std::uint32_t kBatch = 1024;  // pairs of a batch, if there is room for that many batches
constexpr std::uint32_t kLargestBatch = 1 << 16;
constexpr double kNearest = 1e-6;  // depth, in units of the bounds' diagonal
constexpr double kSliceMs = 25;
constexpr int kWindow = 8;         // fragments that a pixel keeps to put late ones in order

std::uint32_t groups_of(std::uint64_t items, std::uint64_t each) { return static_cast<std::uint32_t>((items + each - 1) / each); }

/// Room for what was needed and a quarter more, at most `most`.
std::uint32_t with_slack(std::uint64_t need, std::uint64_t most) {
  return static_cast<std::uint32_t>(std::min(std::max<std::uint64_t>(need + need / 4, 4096), most));
}

double now_ms() { return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

}  // namespace

TilePipeline::TilePipeline(ComputeDevice& device) : device_(device), gl_(device.gl()), batch_size_(kBatch) {
  const std::uint64_t largest = device.largest_buffer();
  most_pairs_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(largest / 8, 1u << 31));
  largest_part_ = largest >= (std::uint64_t{4096} * 4096 * 16) ? 4096 : 2048;
  device_.reserve(frame_, sizeof(shaders::TileFrame), "a frame");
  device_.reserve(counters_, TILE_COUNTER_WORDS * 4, "counters");
  device_.reserve(groups_, (TILE_GROUPS_BLEND + TILE_MOST_SLICES) * 16, "work groups");
}

GLuint TilePipeline::program(const char* source, const std::string& defines) {
  GlObject& program = programs_[{source, defines}];
  if (!program) {
    const std::string shared = std::string(shaders::tile_layout_h) + shaders::tiles_glsl;
    program = make_compute_program(gl_, shared.c_str(), source, defines);
  }
  return program.name();
}

void TilePipeline::dispatch(GLuint program, std::uint64_t groups) {
  if (groups == 0) return;
  const auto x = static_cast<GLuint>(std::min<std::uint64_t>(groups, TILE_ROW_GROUPS));
  gl_.UseProgram(program);
  gl_.DispatchCompute(x, static_cast<GLuint>((groups + x - 1) / x), 1);
  device_.barrier();
}

void TilePipeline::dispatch_indirect(GLuint program, std::uint32_t row) {
  gl_.UseProgram(program);
  gl_.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, groups_.name());
  gl_.DispatchComputeIndirect(static_cast<GLintptr>(row * 16));
  device_.barrier();
}

/// A GPU that others share, or that a system watches, is not held longer than a slice takes.
void TilePipeline::blend(GLuint program) {
  gl_.ProgramUniform1ui(program, TILE_UNIFORM_SLICES, slices_);
  for (std::uint32_t slice = 0; slice < slices_; ++slice) {
    gl_.ProgramUniform1ui(program, TILE_UNIFORM_SLICE, slice);
    dispatch_indirect(program, TILE_GROUPS_BLEND + slice);
    if (slices_ > 1) gl_.Flush();
  }
}

/// From what blending took last.
void TilePipeline::plan_slices() {
  const auto blended = std::find_if(stages_.begin(), stages_.end(), [](const StageTime& of) { return of.name == "blend"; });
  if (blended != stages_.end()) slices_ = static_cast<std::uint32_t>(std::clamp(std::ceil(blended->ms / kSliceMs), 1.0, double{TILE_MOST_SLICES}));
}

// count 0: the digits of all blocks of the sort.
void TilePipeline::scan(const ComputeBuffer& elements, std::uint32_t count, std::uint32_t total) {
  device_.bind(TILE_SUMS, elements);
  device_.bind(TILE_PARTIALS, partials_);
  for (const char* step : {"#define REDUCE\n", "#define SPINE\n", "#define APPLY\n"}) {
    const GLuint p = program(shaders::tile_scan_comp, step);
    gl_.ProgramUniform1ui(p, TILE_UNIFORM_ELEMENTS, count);
    const bool spine = std::strcmp(step, "#define SPINE\n") == 0;
    if (spine) gl_.ProgramUniform1ui(p, TILE_UNIFORM_TOTAL, total);
    if (spine)
      dispatch(p, 1);
    else if (count > 0)
      dispatch(p, groups_of(count, TILE_SCAN_TILE));
    else
      dispatch_indirect(p, TILE_GROUPS_SORT_SCAN);
  }
}

void TilePipeline::sort(std::uint32_t bits) {
  const GLuint count = program(shaders::tile_sort_comp, "#define COUNT\n"), scatter = program(shaders::tile_sort_comp, "");
  for (std::uint32_t shift = 0; shift < bits; shift += TILE_SORT_BITS) {
    device_.bind(TILE_SUMS, sums_);
    device_.bind(TILE_PAIRS, pairs_);
    device_.bind(TILE_SORTED, sorted_);
    gl_.ProgramUniform1ui(count, TILE_UNIFORM_SHIFT, shift);
    gl_.ProgramUniform1ui(scatter, TILE_UNIFORM_SHIFT, shift);
    dispatch_indirect(count, TILE_GROUPS_SORT);
    scan(sums_, 0, TILE_COUNTER_WORDS);
    dispatch_indirect(scatter, TILE_GROUPS_SORT);
    std::swap(pairs_, sorted_);
  }
  device_.bind(TILE_PAIRS, pairs_);
}

shaders::TileFrame TilePipeline::frame_of(const TilePicture& picture, const TilePart& part) const {
  const DrawInput& input = *picture.input;
  const TileMesh& mesh = *picture.mesh;
  const Camera& camera = input.camera;
  const Mat4d view = view_from_world(camera);
  const double scale = mesh.scale();
  shaders::TileFrame f{};
  const auto axis = [&](auto& row, std::size_t of, double sign) {  // view space of view_from_world is y up, z backwards
    const Vec3d a{sign * view.m[0][of], sign * view.m[1][of], sign * view.m[2][of]};
    row = {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z),
           static_cast<float>(dot(a, mesh.middle() - camera.eye) / scale)};
  };
  axis(f.right, 0, 1);
  axis(f.down, 1, -1);
  axis(f.forward, 2, -1);
  const PixelGrid grid = pixel_grid(input);
  const double pixels = camera.orthographic ? grid.per_unit * scale : grid.focal;
  f.lens = {static_cast<float>(pixels), static_cast<float>(1 / pixels), static_cast<float>(grid.axis_x - part.x),
            static_cast<float>(grid.axis_y - part.y)};
  const double distance = length(camera.at - camera.eye) / scale;
  f.limits = {static_cast<float>(kNearest * std::min(1.0, distance)),
              input.count_fragments ? -1.0f
              : input.float_image && !input.rounded ? 1e-7f
                                                    : 1e-4f,
              camera.orthographic ? 0.0f : 1.0f, input.count_fragments ? 1.0f : 0.0f};
  f.background = {input.background[0], input.background[1], input.background[2],
                  static_cast<float>(2 * picture.styles->first_drawn + (input.transparent ? 1 : 0))};
  f.part = {static_cast<std::uint32_t>(part.width), static_cast<std::uint32_t>(part.height),
            groups_of(static_cast<std::uint64_t>(part.width), 16), groups_of(static_cast<std::uint64_t>(part.height), 16)};
  const TileOrder& order = *picture.order;
  const std::uint32_t group_bits =
      order.kind == TILE_ORDER_LIST ? 0 : static_cast<std::uint32_t>(std::bit_width(picture.styles->groups - 1));
  f.keys = {order.kind, order.depth_bits, order.depth_bits + group_bits, static_cast<std::uint32_t>(input.clip_planes.size())};
  f.eye_cell = {order.eye_cell[0], order.eye_cell[1], order.eye_cell[2], mesh.tetrahedra()};
  f.room = {order.kind == TILE_ORDER_LIST ? static_cast<std::uint32_t>(order.list.size()) : mesh.tetrahedra(), pair_room_,
            batch_room_, batch_size_};
  return f;
}

std::string TilePipeline::blend_defines(const TilePicture& picture) const {
  const TileStyles& styles = *picture.styles;
  std::string defines = "#define USES_MESH\n";
  if (styles.one_color) return defines + "#define ONE_COLOR\n#define WINDOW 0\n";
  const bool window = picture.order->kind != TILE_ORDER_NONE && !picture.order->list_exact;
  defines += "#define WINDOW " + std::to_string(window ? kWindow : 0) + "\n";
  if (styles.linear && picture.mesh->has_values()) {
    defines += "#define LINEAR_COLOR\n";
    if (picture.input->integral == Integral::table2d) defines += "#define TABLE_2D\n";
  }
  if (picture.mesh->has_shades()) defines += "#define BODY_SHADING\n";
  if (styles.surfaces) {
    defines += "#define SURFACES\n";
    if (picture.mesh->has_normals()) defines += "#define WITH_NORMALS\n";
    if (picture.mesh->has_texture()) defines += "#define WITH_TEXTURE\n";
  }
  return defines;
}

void TilePipeline::begin(const TilePicture& picture) {
  const DrawInput& input = *picture.input;
  const Task task;
  plan_slices();
  stages_.clear();
  readback_ms_ = 0;
  device_.reserve(styles_, picture.styles->rows.size() * 16, "the styles");
  device_.upload(styles_, 0, bytes_of(picture.styles->rows), task);

  const Mat4d view = view_from_world(input.camera);
  std::vector<std::array<float, 4>> planes;
  for (const ClipPlane& plane : input.clip_planes) {
    const auto along = [&](std::size_t of) {
      return static_cast<float>(view.m[0][of] * plane.normal.x + view.m[1][of] * plane.normal.y + view.m[2][of] * plane.normal.z);
    };
    planes.push_back({along(0), -along(1), -along(2),
                      static_cast<float>((plane.offset - dot(plane.normal, input.camera.eye)) / picture.mesh->scale())});
  }
  device_.reserve(clip_planes_, planes.size() * 16, "the clip planes");
  device_.upload(clip_planes_, 0, bytes_of(planes), task);
  device_.reserve(order_, 16, "the order");  // something is bound if there is none
  if (picture.order->kind == TILE_ORDER_LIST) {
    device_.reserve(order_, picture.order->list.size() * 4, "the order");
    device_.upload(order_, 0, bytes_of(picture.order->list), task);
  }
  if (pair_room_ == 0) pair_room_ = with_slack(2ull * picture.mesh->tetrahedra(), std::min<std::uint64_t>(most_pairs_, 1 << 22));
  if (batch_room_ == 0) batch_room_ = std::min<std::uint32_t>(1024, most_batches());
}

void TilePipeline::give_back() {
  for (ComputeBuffer* of : {&styles_, &clip_planes_, &order_, &sums_, &partials_, &pairs_, &sorted_, &ranges_, &batches_, &light_, &nearest_, &picture_, &depth_})
    device_.free(*of);
  pair_room_ = batch_room_ = 0;
  batch_size_ = kBatch;
}

void TilePipeline::run(const TilePicture& picture, std::uint32_t key_bits) {
  const bool depth = picture.input->float_image;
  const std::uint32_t slots = current_.room.x, tiles = current_.part.z * current_.part.w;
  picture.mesh->bind();
  device_.bind(TILE_STYLES, styles_);
  device_.bind(TILE_COUNTERS, counters_);
  device_.bind(TILE_CLIP_PLANES, clip_planes_);
  device_.bind(TILE_ORDER, order_);
  device_.bind(TILE_GROUPS, groups_);
  device_.bind(TILE_RANGES, ranges_);

  device_.bind(TILE_SUMS, sums_);
  device_.bind(TILE_PAIRS, pairs_);
  const GLuint plan = program(shaders::tile_plan_comp, "");
  dispatch(program(shaders::tile_cover_comp, "#define USES_MESH\n"), groups_of(std::uint64_t{slots} + 1, TILE_GROUP));
  scan(sums_, slots + 1, TILE_COUNT_PAIRS);
  dispatch(program(shaders::tile_cover_comp, "#define USES_MESH\n#define FILL\n"), groups_of(slots, TILE_GROUP));
  gl_.ProgramUniform1ui(plan, TILE_UNIFORM_PLAN, 0);
  dispatch(plan, 1);
  mark("cover");

  sort(key_bits);
  mark("sort");

  device_.bind(TILE_SUMS, batches_);
  dispatch(program(shaders::tile_ranges_comp, ""), groups_of(tiles + 1, TILE_GROUP));
  scan(batches_, tiles + 1, TILE_COUNT_BATCHES);
  gl_.ProgramUniform1ui(plan, TILE_UNIFORM_PLAN, 1);
  gl_.ProgramUniform1ui(plan, TILE_UNIFORM_SLICES, slices_);
  dispatch(plan, 1);
  mark("batches");

  const std::string defines = blend_defines(picture),
                    nearest = std::string(depth ? "#define NEAREST_DEPTH\n" : "") + (depth && picture.input->mean_depth ? "#define MEAN_DEPTH\n" : "");
  device_.bind(TILE_LIGHT, light_);
  if (depth) device_.bind(TILE_NEAREST, nearest_);
  picture.mesh->bind_arrays();
  blend(program(shaders::tile_blend_comp, defines + nearest));
  mark("blend");

  device_.bind(TILE_PICTURE, picture_);
  if (depth) device_.bind(TILE_DEPTH, depth_);
  dispatch(program(shaders::tile_merge_comp, nearest), tiles);
  mark("merge");
}

TileDrawn TilePipeline::draw(const TilePicture& picture, const TilePart& part, Image* bytes, FloatImage* floats) {
  const std::uint64_t pixels = static_cast<std::uint64_t>(part.width) * static_cast<std::uint64_t>(part.height);
  const Task task;
  for (int attempt = 0;; ++attempt) {
    current_ = frame_of(picture, part);
    const std::uint32_t tiles = current_.part.z * current_.part.w;
    const std::uint32_t key_bits = current_.keys.z + static_cast<std::uint32_t>(std::bit_width(tiles));  // one number more than tiles
    const std::uint64_t blocks = groups_of(pair_room_, TILE_SORT_TILE);
    const std::uint64_t elements = std::max<std::uint64_t>(std::uint64_t{current_.room.x} + 1, blocks * TILE_SORT_DIGITS);
    device_.reserve(sums_, elements * 4, "counts of tetrahedra");
    device_.reserve(partials_, groups_of(std::max<std::uint64_t>(elements, tiles + 1), TILE_SCAN_TILE) * 4ull, "a scan");
    device_.reserve(pairs_, pair_room_ * 8ull, "pairs of tile and tetrahedron");
    device_.reserve(sorted_, pair_room_ * 8ull, "pairs of tile and tetrahedron");
    device_.reserve(ranges_, (tiles + 1) * 8ull, "tiles");
    device_.reserve(batches_, (tiles + 1) * 4ull, "tiles");
    device_.reserve(light_, batch_room_ * (TILE_GROUP * 16ull), "batches of light");
    const std::uint64_t depths = floats && !floats->mean_depth.empty() ? 2 : 1;
    if (floats) device_.reserve(nearest_, depths * batch_room_ * (TILE_GROUP * 4ull), "batches of depth");
    device_.reserve(picture_, pixels * (floats ? 16 : 4), "the picture");
    if (floats) device_.reserve(depth_, depths * pixels * 4, "the picture's depth");

    device_.clear(counters_, TILE_COUNTER_WORDS * 4);
    device_.upload(frame_, 0, std::as_bytes(std::span(&current_, 1)), task);
    gl_.BindBufferBase(GL_UNIFORM_BUFFER, TILE_BLOCK_FRAME, frame_.name());
    start_clock();
    run(picture, key_bits);

    std::array<std::uint32_t, TILE_COUNTER_WORDS> counters{};
    device_.finish(task);
    stop_clock();
    const Stopwatch watch;
    device_.read(counters_, 0, std::as_writable_bytes(std::span(counters)), task);
    const std::uint32_t pairs = counters[TILE_COUNT_PAIRS], batches = counters[TILE_COUNT_BATCHES];
    if (pairs > pair_room_) {
      if (pairs > most_pairs_) return {.too_many = true};
      pair_room_ = with_slack(pairs, most_pairs_);
    } else if (batches > batch_room_) {
      if (batches <= most_batches())
        batch_room_ = with_slack(batches, most_batches());
      else if (batch_size_ < kLargestBatch)
        batch_size_ *= 2;
      else
        return {.too_many = true};
    } else {
      read(part, bytes, floats, counters);
      readback_ms_ += watch.elapsed_ms();
      return {.fragments = static_cast<std::int64_t>(counters[TILE_COUNT_FRAGMENTS] |
                                                     std::uint64_t{counters[TILE_COUNT_FRAGMENTS + 1]} << 32),
              .late = counters[TILE_COUNT_LATE]};
    }
    if (attempt > 40) throw Error(ErrorCode::internal, "renderer compute: a part of the picture never has enough room");
  }
}

void TilePipeline::read(const TilePart& part, Image* bytes, FloatImage* floats, std::array<std::uint32_t, TILE_COUNTER_WORDS>&) {
  const Task task;
  const int width = bytes ? bytes->width : floats->width;
  const auto at = static_cast<std::size_t>(part.y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(part.x);
  const auto part_width = static_cast<std::size_t>(part.width), part_pixels = part_width * static_cast<std::size_t>(part.height);
  // A part as wide as the picture is in one piece; else it comes by way of rows of its own.
  const auto take = [&]<class T>(const ComputeBuffer& from, std::vector<T>& to, std::size_t each, std::size_t first = 0) {
    if (part.width == width) {
      device_.read(from, first * sizeof(T), std::as_writable_bytes(std::span(to).subspan(at * each, part_pixels * each)), task);
      return;
    }
    std::vector<T> rows(part_pixels * each);
    device_.read(from, first * sizeof(T), std::as_writable_bytes(std::span(rows)), task);
    for (std::size_t y = 0; y < static_cast<std::size_t>(part.height); ++y)
      std::copy_n(&rows[y * part_width * each], part_width * each, &to[(at + y * static_cast<std::size_t>(width)) * each]);
  };
  if (bytes) {
    take(picture_, bytes->rgba, 4);
    return;
  }
  take(picture_, floats->rgba, 4);
  if (!floats->depth.empty()) take(depth_, floats->depth, 1);
  if (!floats->mean_depth.empty()) take(depth_, floats->mean_depth, 1, part_pixels);
}

void TilePipeline::start_clock() {
  marks_.clear();
  last_ms_ = now_ms();
  mark("");
}

// A GPU is asked for its time; a software device is waited for.
void TilePipeline::mark(const char* stage) {
  if (!device_.context().software()) {
    GlObject query;
    if (spare_queries_.empty())
      query = make_query(gl_, GL_TIMESTAMP);
    else {
      query = std::move(spare_queries_.back());
      spare_queries_.pop_back();
    }
    gl_.QueryCounter(query.name(), GL_TIMESTAMP);
    marks_.push_back({stage, std::move(query)});
    return;
  }
  if (*stage == '\0') return;
  gl_.Finish();
  const double now = now_ms();
  const auto known = std::find_if(stages_.begin(), stages_.end(), [&](const StageTime& s) { return s.name == stage; });
  (known != stages_.end() ? *known : stages_.emplace_back(StageTime{stage, 0})).ms += now - last_ms_;
  last_ms_ = now;
}

void TilePipeline::stop_clock() {
  GLuint64 before = 0;
  for (Mark& m : marks_) {
    GLuint64 ns = 0;
    gl_.GetQueryObjectui64v(m.query.name(), GL_QUERY_RESULT, &ns);
    if (*m.stage != '\0') {
      const auto known = std::find_if(stages_.begin(), stages_.end(), [&](const StageTime& s) { return s.name == m.stage; });
      (known != stages_.end() ? *known : stages_.emplace_back(StageTime{m.stage, 0})).ms +=
          static_cast<double>(ns - before) * 1e-6;
    }
    before = ns;
    spare_queries_.push_back(std::move(m.query));
  }
  marks_.clear();
}

}  // namespace isostrata
