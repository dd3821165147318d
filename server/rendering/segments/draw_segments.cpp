#include "rendering/segments/draw_segments.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <mutex>
#include <optional>

#include "base/buffer.h"
#include "base/parallel.h"
#include "base/stopwatch.h"
#include "base/work.h"
#include "rendering/picture/body_shading.h"
#include "rendering/segments/crossable_mesh.h"
#include "rendering/segments/segment_bins.h"
#include "rendering/segments/segment_crossings.h"
#include "rendering/segments/segment_fragments.h"
#include "rendering/segments/segment_lists.h"
#include "rendering/segments/segment_optics.h"
#include "rendering/segments/segment_rays.h"
#include "rendering/segments/segment_surfaces.h"
#include "rendering/segments/segment_view.h"

namespace isostrata {
namespace {

constexpr std::size_t kFirstCapacity = std::size_t{1} << 16, kMostFragments = std::size_t{1} << 20;

/// A thread's memory: of one tile, kept from tile to tile.
struct TileMemory {
  Buffer<float> light;
  Buffer<std::uint32_t> far_key;
  Buffer<std::uint16_t> pixel;
  Buffer<float> q_in;
  FragmentStore store;
  PixelLists lists;
  SegmentPixels pixels;
  CoverBatch batch;
  CoverScratch scratch;
  CrossingBatch crossing_batch;
  CrossingLists crossings;
  std::vector<SegmentEntry> nearest_first, sorted;
  std::vector<std::uint32_t> surfaces;
  float q_low[kTilePixels], q_high[kTilePixels];
  float planes[5][kTilePixels];

  /// Room for `capacity` fragments, and for what vectors write beyond the last one.
  void reserve(std::size_t capacity, bool depth) {
    light.resize(4 * (capacity + 64));
    far_key.resize(capacity + 64);
    pixel.resize(capacity + 64);
    if (depth) q_in.resize(capacity + 64);
    store.light = light.data();
    store.far_key = far_key.data();
    store.pixel = pixel.data();
    store.q_in = depth ? q_in.data() : nullptr;
    store.capacity = capacity;
  }
};

/// The nearest first, nearly: by counting into steps of equal size. Enough for lists that are sorted exactly later.
void sort_by_nearness(std::vector<SegmentEntry>& entries, std::vector<SegmentEntry>& sorted) {
  constexpr std::size_t kSteps = 1024;
  if (entries.size() < 64) {
    std::sort(entries.begin(), entries.end(),
              [](const SegmentEntry& a, const SegmentEntry& b) { return a.nearness > b.nearness; });
    return;
  }
  float least = std::numeric_limits<float>::infinity(), most = -least;
  for (const SegmentEntry& e : entries) least = std::min(least, e.nearness), most = std::max(most, e.nearness);
  const float per_step = most > least ? (kSteps - 1) / (most - least) : 0.0f;
  std::array<std::uint32_t, kSteps> at{};
  const auto step = [&](const SegmentEntry& e) {
    return std::min(static_cast<std::size_t>((most - e.nearness) * per_step), kSteps - 1);
  };
  for (const SegmentEntry& e : entries) ++at[step(e)];
  std::uint32_t sum = 0;
  for (std::uint32_t& count : at) sum += std::exchange(count, sum);
  sorted.resize(entries.size());
  for (const SegmentEntry& e : entries) sorted[at[step(e)]++] = e;
  entries.swap(sorted);
}

}  // namespace

struct SegmentsRenderer::State {
  PlacedMesh placed;
  ColorIntegralMemory colors;
  // Of the mesh and values that were drawn last:
  std::weak_ptr<const IntervalMesh> mesh;
  std::weak_ptr<const std::vector<float>> values;
  std::vector<SegmentRange> ranges;  // [intervals]
  std::optional<CrossableMesh> crossable;
  std::mutex mutex;                // of memory
  std::vector<std::unique_ptr<TileMemory>> memory;

  std::unique_ptr<TileMemory> lend() {
    const std::lock_guard lock(mutex);
    if (memory.empty()) return std::make_unique<TileMemory>();
    auto one = std::move(memory.back());
    memory.pop_back();
    return one;
  }
  void give_back(std::unique_ptr<TileMemory> one) {
    const std::lock_guard lock(mutex);
    memory.push_back(std::move(one));
  }
};

namespace {

/// A frame's tiles.
class TilePainter {
 public:
  TilePainter(const DrawInput& input, TileSink& sink, const SegmentView& view, const SegmentOptics& optics,
              const PlacedMesh& placed, const SegmentSurfaces& surfaces, const CrossableMesh* crossable)
      : input_(input), sink_(sink), view_(view), optics_(optics), placed_(placed), surfaces_(surfaces), crossable_(crossable) {
    if (crossable) prepare_crossings();
    for (const ClipPlane& plane : input.clip_planes) half_spaces_.push_back(on_screen(plane, view));
  }

  void paint(std::size_t tile, TileMemory& memory) {
    const int tile_x = static_cast<int>(tile) % placed_.tiles_x * kTileSize,
              tile_y = static_cast<int>(tile) / placed_.tiles_x * kTileSize;
    CoverInput part;
    part.view = &view_;
    part.optics = &optics_;
    part.integral = input_.integral;
    part.shaded = !placed_.shades.empty();
    part.tile_x = tile_x;
    part.tile_y = tile_y;
    part.x1 = std::min(kTileSize, view_.width - tile_x) - 1;
    part.y1 = std::min(kTileSize, view_.height - tile_y) - 1;
    memory.pixels.clear();
    const auto entries = placed_.bins.of(tile), surfaces = surfaces_.in_tile(tile);
    if (crossable_ && cover_many_pixels(entries) && paint_crossings(entries, part, memory)) {
      put(part, memory);
      return;
    }
    if (!entries.empty() || !surfaces.empty()) {
      const bool any_depth = sink_.wants_depth() || sink_.wants_mean_depth();
      if (memory.store.capacity == 0 || (any_depth != (memory.store.q_in != nullptr))) memory.reserve(kFirstCapacity, any_depth);
      if (!half_spaces_.empty()) limit_rays(part, memory);
      for (int group = 0; group < optics_.groups; ++group) paint_group(group, entries, surfaces, part, memory);
    }
    put(part, memory);
  }
  std::int64_t fragments() const { return fragments_; }

 private:
  void limit_rays(CoverInput& part, TileMemory& memory) const {
    for (int p = 0; p < kTilePixels; ++p) {
      double low = -1e30, high = 1e30;
      const double x = part.tile_x + p % kTileSize, y = part.tile_y + p / kTileSize;
      for (const ScreenHalfSpace& half : half_spaces_) {
        const double q = half.at + half.per_x * x + half.per_y * y;
        if (half.keeps_nearer)
          low = std::max(low, q);
        else
          high = std::min(high, q);
      }
      memory.q_low[p] = static_cast<float>(std::min(low, 1e30));
      memory.q_high[p] = static_cast<float>(std::max(high, -1e30));
    }
    part.q_low = memory.q_low;
    part.q_high = memory.q_high;
  }

  std::uint32_t interval_of(std::uint32_t id) const {
    const std::size_t count = placed_.first_piece;
    if (id >= count) return placed_.pieces[id - count].interval;
    return optics_.cut ? placed_.reached[id].interval : input_.mesh->tetrahedron_interval[id];
  }
  const std::array<std::uint32_t, 4>& points_of(std::uint32_t id) const {
    return optics_.cut ? placed_.reached[id].points : input_.mesh->tetrahedra[id];
  }

  void prepare_crossings() {
    crossing_.orthographic = view_.orthographic;
    crossing_.mirrored = crossable_->mirrored;
    walk_.view = &view_;
    walk_.depth = sink_.wants_depth();
    walk_.mean_depth = sink_.wants_mean_depth();
    for (std::size_t i = 0; i < optics_.group.size(); ++i) {
      if (optics_.group[i] < 0) continue;
      crossing_.lower[i] = optics_.lower[i];
      crossing_.per_value[i] = optics_.inverse_range[i] * kMapSteps;
      walk_.integrals = optics_.looks[static_cast<std::size_t>(optics_.look[i])].integrals.get();
    }
    // Of those that are not drawn that of one that is: then there is one extinction more often.
    for (std::size_t i = 0; i < walk_.extinction.size(); ++i) {
      const auto drawn = std::find_if(optics_.group.begin(), optics_.group.end(), [](std::int32_t group) { return group >= 0; });
      const auto first = static_cast<std::size_t>(drawn - optics_.group.begin());
      walk_.extinction[i] = optics_.extinction[i < optics_.group.size() && optics_.group[i] >= 0 ? i : first];
    }
  }

  /// Whether it is worth while to go through faces: the work of a face counts most where tetrahedra are small. By a sample.
  bool cover_many_pixels(std::span<const SegmentEntry> entries) const {
    constexpr std::size_t kSample = 32;
    constexpr float kManyPixels = 60;  // of a tetrahedron's rectangle; a third of them are covered
    const std::size_t step = std::max<std::size_t>(1, entries.size() / kSample);
    float sum = 0, count = 0;
    for (std::size_t i = 0; i < entries.size(); i += step, ++count) {
      const auto& points = input_.mesh->tetrahedra[entries[i].id];
      const SegmentVertex* const v[4] = {&placed_.points[points[0]], &placed_.points[points[1]], &placed_.points[points[2]],
                                         &placed_.points[points[3]]};
      const auto [x_low, x_high] = std::minmax({v[0]->x, v[1]->x, v[2]->x, v[3]->x});
      const auto [y_low, y_high] = std::minmax({v[0]->y, v[1]->y, v[2]->y, v[3]->y});
      sum += (x_high - x_low) * (y_high - y_low);
    }
    return sum > kManyPixels * count;
  }

  /// The whole tile by crossings. False if a ray has too many of them.
  bool paint_crossings(std::span<const SegmentEntry> entries, const CoverInput& part, TileMemory& memory) const {
    memory.nearest_first.assign(entries.begin(), entries.end());
    sort_by_nearness(memory.nearest_first, memory.sorted);
    memory.crossings.clear();
    CrossingInput input = crossing_;
    input.tile_x = part.tile_x;
    input.tile_y = part.tile_y;
    input.width = part.x1 + 1;
    input.height = part.y1 + 1;
    CrossingBatch& batch = memory.crossing_batch;
    for (std::size_t begin = 0; begin < memory.nearest_first.size(); begin += CrossingBatch::kCapacity) {
      checkpoint();
      gather(std::span(memory.nearest_first), begin, batch);
      if (!cross_faces(input, batch, memory.crossings)) return false;
    }
    RayWalk walk = walk_;
    walk.tile_x = part.tile_x;
    walk.tile_y = part.tile_y;
    walk_rays(walk, memory.crossings, memory.pixels);
    return true;
  }

  void gather(std::span<const SegmentEntry> entries, std::size_t begin, CrossingBatch& batch) const {
    constexpr std::size_t kPointsAhead = 12, kIdsAhead = 32;
    const IntervalMesh& mesh = *input_.mesh;
    batch.count = std::min(CrossingBatch::kCapacity, entries.size() - begin);
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::size_t at = begin + i;
      if (const std::size_t ahead = at + kIdsAhead; ahead < entries.size()) {
        __builtin_prefetch(&mesh.tetrahedra[entries[ahead].id]);
        __builtin_prefetch(&crossable_->surface[entries[ahead].id]);
      }
      if (const std::size_t ahead = at + kPointsAhead; ahead < entries.size())
        for (const std::uint32_t point : mesh.tetrahedra[entries[ahead].id]) __builtin_prefetch(&placed_.points[point]);
      const std::uint32_t id = entries[at].id;
      batch.interval[i] = static_cast<std::uint8_t>(mesh.tetrahedron_interval[id]);
      batch.surface[i] = crossable_->surface[id];
      for (std::size_t v = 0; v < 4; ++v) batch.vertex[v][i] = placed_.points[mesh.tetrahedra[id][v]];
    }
  }

  void paint_group(int group, std::span<const SegmentEntry> entries, std::span<const SegmentEntry> surfaces,
                   const CoverInput& part, TileMemory& memory) {
    memory.nearest_first.clear();
    if (optics_.groups == 1)
      memory.nearest_first.assign(entries.begin(), entries.end());
    else
      for (const SegmentEntry& e : entries)
        if (optics_.group[interval_of(e.id)] == group) memory.nearest_first.push_back(e);
    memory.surfaces.clear();
    for (const SegmentEntry& e : surfaces)
      if (optics_.surface_group[surfaces_.interval(e.id)] == group) memory.surfaces.push_back(e.id);
    if (memory.nearest_first.empty() && memory.surfaces.empty()) return;
    sort_by_nearness(memory.nearest_first, memory.sorted);
    paint_part(part, memory);
  }

  /// The corners of the entries from `begin` on. They lie about in memory, so they are asked for some time before.
  void gather(const std::vector<SegmentEntry>& entries, std::size_t begin, CoverBatch& batch) const {
    constexpr std::size_t kPointsAhead = 12, kIdsAhead = 32;
    const std::size_t count = placed_.first_piece;
    const bool shaded = !placed_.shades.empty();
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::size_t at = begin + i;
      if (const std::size_t ahead = at + kIdsAhead; ahead < entries.size() && entries[ahead].id < count) {
        __builtin_prefetch(&points_of(entries[ahead].id));
        if (!optics_.cut) __builtin_prefetch(&input_.mesh->tetrahedron_interval[entries[ahead].id]);
      }
      if (const std::size_t ahead = at + kPointsAhead; ahead < entries.size() && entries[ahead].id < count)
        for (const std::uint32_t point : points_of(entries[ahead].id)) {
          __builtin_prefetch(&placed_.points[point]);
          if (shaded) __builtin_prefetch(&placed_.shades[point]);
        }
      const std::uint32_t id = entries[at].id;
      batch.interval[i] = static_cast<std::int32_t>(interval_of(id));
      for (std::size_t v = 0; v < 4; ++v)
        batch.vertex[v][i] = id < count ? placed_.points[points_of(id)[v]] : placed_.pieces[id - count].vertex[v];
      if (optics_.cut) lay_inside(batch, i);
      if (shaded)
        for (std::size_t v = 0; v < 4; ++v)
          batch.shade[v][i] = id < count ? placed_.shades[points_of(id)[v]] : placed_.pieces[id - count].shade[v];
    }
  }

  /// Where the field does not change and just lies on an end, rounding must not decide whether it is inside.
  void lay_inside(CoverBatch& batch, std::size_t i) const {
    const float value = batch.vertex[0][i].value;
    if (batch.vertex[1][i].value != value || batch.vertex[2][i].value != value || batch.vertex[3][i].value != value) return;
    const Interval& interval = input_.cut_intervals[static_cast<std::size_t>(batch.interval[i])];
    const double margin = 1e-3 * (interval.upper - interval.lower);
    for (auto& corner : batch.vertex)
      corner[i].value = static_cast<float>(std::clamp(double{value}, interval.lower + margin, interval.upper - margin));
  }

  /// The group's tetrahedra and surfaces in a part of the tile; in four parts of that where its fragments take too much memory.
  void paint_part(const CoverInput& part, TileMemory& memory) {
    FragmentStore& store = memory.store;
    store.count = 0;
    const auto make_room = [&](std::size_t wanted) {  // false: the part must be split
      if (store.capacity - store.count >= wanted) return true;
      if (store.capacity >= kMostFragments && (part.x1 - part.x0 > 1 || part.y1 - part.y0 > 1)) return false;
      memory.reserve(std::max(2 * store.capacity, store.count + wanted), store.q_in != nullptr);
      return true;
    };
    const auto& entries = memory.nearest_first;
    for (std::size_t begin = 0; begin < entries.size(); begin += CoverBatch::kCapacity) {
      checkpoint();  // a tile of hundreds of layers takes far longer than others should wait
      CoverBatch& batch = memory.batch;
      batch.count = std::min(CoverBatch::kCapacity, entries.size() - begin);
      gather(entries, begin, batch);
      for (std::size_t done = 0; done < batch.count;) {
        if (!make_room(kLightRoom)) return paint_quarters(part, memory);
        done = cover_tile(part, batch, done, memory.scratch, store);
      }
    }
    for (const std::uint32_t triangle : memory.surfaces) {
      if (!make_room(surfaces_.room(triangle, part))) return paint_quarters(part, memory);
      surfaces_.add(triangle, part, store);
    }
    fragments_ += static_cast<std::int64_t>(store.count);
    blend_fragments(store, memory.lists, memory.pixels, sink_.wants_mean_depth() ? &view_ : nullptr);
  }

  void paint_quarters(const CoverInput& part, TileMemory& memory) {
    const int x_middle = (part.x0 + part.x1) / 2, y_middle = (part.y0 + part.y1) / 2;
    for (int quarter = 0; quarter < 4; ++quarter) {
      CoverInput one = part;
      (quarter & 1 ? one.x0 : one.x1) = x_middle + (quarter & 1);
      (quarter & 2 ? one.y0 : one.y1) = y_middle + (quarter >> 1);
      if (one.x0 <= one.x1 && one.y0 <= one.y1) paint_part(one, memory);
    }
  }

  void put(const CoverInput& part, TileMemory& memory) {
    FinishedTile tile;
    tile.x = part.tile_x;
    tile.y = part.tile_y;
    tile.width = part.x1 + 1;
    tile.height = part.y1 + 1;
    tile.stride = kTileSize;
    for (int p = 0; p < kTilePixels; ++p) {
      for (int c = 0; c < 3; ++c) memory.planes[c][p] = memory.pixels.light[p][c];
      memory.planes[3][p] = 1 - memory.pixels.light[p][3];
    }
    for (int c = 0; c < 4; ++c) tile.rgba[c] = memory.planes[c];
    if (sink_.wants_depth()) {
      for (int p = 0; p < kTilePixels; ++p) {
        const float q = memory.pixels.nearest_q[p];
        memory.planes[4][p] = q > -1e29f ? static_cast<float>(view_.depth_of(double{q})) : std::numeric_limits<float>::infinity();
      }
      tile.depth = memory.planes[4];
    }
    if (sink_.wants_mean_depth()) {
      for (float& depth : memory.pixels.mean_depth) depth *= static_cast<float>(view_.scale);
      tile.mean_depth = memory.pixels.mean_depth;
    }
    sink_.put(tile);
  }

  const DrawInput& input_;
  TileSink& sink_;
  const SegmentView& view_;
  const SegmentOptics& optics_;
  const PlacedMesh& placed_;
  const SegmentSurfaces& surfaces_;
  const CrossableMesh* const crossable_;  // null: by segments
  CrossingInput crossing_;                // of all tiles
  RayWalk walk_;
  std::vector<ScreenHalfSpace> half_spaces_;
  std::atomic<std::int64_t> fragments_{0};
};

}  // namespace

namespace {

/// Whether rays can go from face to face as far as the styles are concerned: one colour map over values that lie in its range,
/// extinctions that are constant within an interval, intervals that do not overlap, nothing that cuts the rays or lies on them.
bool by_crossings(const DrawInput& input, const SegmentOptics& optics, const std::vector<SegmentRange>& ranges) {
  constexpr float kBeyond = 1e-4f;
  // Where tetrahedra are small faces are not worth their work, and to find them takes time with each new mesh.
  constexpr std::size_t kPixelsPerTetrahedron = 16;
  if (input.mesh->tetrahedra.size() * kPixelsPerTetrahedron > static_cast<std::size_t>(input.width) * static_cast<std::size_t>(input.height))
    return false;
  if (optics.cut || shades_bodies(input) || optics.groups != 1 || input.integral != Integral::exact || !input.clip_planes.empty() || input.count_fragments)
    return false;
  if (optics.group.size() > kMostCrossedIntervals) return false;
  const ColorIntegrals* integrals = nullptr;
  for (std::size_t i = 0; i < optics.group.size(); ++i) {
    if (optics.group[i] < 0) continue;
    if (optics.look[i] < 0) return false;
    const ColorIntegrals* const own = optics.looks[static_cast<std::size_t>(optics.look[i])].integrals.get();
    if (integrals && own != integrals) return false;
    integrals = own;
    const float a = (ranges[i].least - optics.lower[i]) * optics.inverse_range[i],
                b = (ranges[i].most - optics.lower[i]) * optics.inverse_range[i];
    if (input.mesh->summaries[i].tetrahedra > 0 && !(std::min(a, b) >= -kBeyond && std::max(a, b) <= 1 + kBeyond)) return false;
    const Interval& one = input.mesh->summaries[i].interval;
    for (std::size_t j = 0; j < i; ++j) {
      const Interval& other = input.mesh->summaries[j].interval;
      if (optics.group[j] >= 0 && one.lower < other.upper && other.lower < one.upper) return false;
    }
  }
  return integrals != nullptr;
}

}  // namespace

SegmentsRenderer::SegmentsRenderer() : state_(std::make_unique<State>()) {}
SegmentsRenderer::~SegmentsRenderer() = default;

void SegmentsRenderer::draw(const DrawInput& input, TileSink& sink, DrawFacts& facts) {
  const Stopwatch order_watch;
  const SegmentView view = make_segment_view(input);
  SegmentOptics optics = make_segment_optics(input, view.scale, &state_->colors);
  if (state_->mesh.lock() != input.mesh || state_->values.lock() != input.color_values) {
    state_->ranges.clear();
    state_->crossable.reset();
    state_->mesh = input.mesh;
    state_->values = input.color_values;
  }
  if (optics.cut) {
    std::vector<SegmentRange> inside;
    for (const Interval& interval : input.cut_intervals)
      inside.push_back({static_cast<float>(interval.lower), static_cast<float>(interval.upper)});
    straighten(inside, optics);
  } else {
    if (state_->ranges.empty()) state_->ranges = value_ranges(*input.mesh, input.color_values.get());
    straighten(state_->ranges, optics);
  }
  place_mesh(input, view, optics, state_->placed);
  const SegmentSurfaces surfaces(input, view, optics, state_->placed.tiles_x, state_->placed.tiles_y);
  const CrossableMesh* crossable = nullptr;
  if (!surfaces.any() && state_->placed.pieces.empty() && by_crossings(input, optics, state_->ranges)) {
    if (!state_->crossable) state_->crossable = make_crossable(*input.mesh);
    if (state_->crossable->crossable) crossable = &*state_->crossable;
  }
  facts.order = "per pixel (exact)";
  facts.order_exact = true;
  facts.tetrahedra = state_->placed.drawn;
  facts.order_ms = order_watch.elapsed_ms();

  const Stopwatch draw_watch;
  TilePainter painter(input, sink, view, optics, state_->placed, surfaces, crossable);
  parallel_for(std::int64_t{state_->placed.tiles_x} * state_->placed.tiles_y, 1, [&](std::int64_t begin, std::int64_t end) {
    auto memory = state_->lend();
    for (std::int64_t tile = begin; tile < end; ++tile) painter.paint(static_cast<std::size_t>(tile), *memory);
    state_->give_back(std::move(memory));
  });
  if (input.count_fragments) facts.fragments = painter.fragments();
  facts.draw_ms = draw_watch.elapsed_ms();
}

}  // namespace isostrata
