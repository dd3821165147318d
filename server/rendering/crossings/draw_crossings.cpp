#include "rendering/crossings/draw_crossings.h"

#include <algorithm>
#include <limits>
#include <map>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "extraction/bricks/layer_bricks.h"
#include "extraction/surfaces/gradient_normals.h"
#include "rendering/crossings/count_fragments.h"
#include "rendering/crossings/crossing_light.h"
#include "rendering/crossings/crossing_list_tile.h"
#include "rendering/crossings/optical_depth_tile.h"
#include "rendering/crossings/project_vertices.h"
#include "rendering/crossings/ray_limits.h"
#include "rendering/crossings/seen_facets.h"
#include "rendering/crossings/walk_simd.h"
#include "rendering/picture/lit_surfaces.h"

namespace isostrata {
namespace {

constexpr std::size_t kTilePixels = static_cast<std::size_t>(kTileWidth) * kTileHeight;
// Together half a step of 8 bits (crossing_frame.h). Behind two surfaces of opacity 0.95 only a third would be seen by 0.0024.
constexpr float kLeastThrough = 1.0f / 2048, kMostUnlit = 1.0f / 340;

bool is_drawn(const IntervalStyle& style) { return style.visible && (style.opacity > 0 || style.surface.drawn()); }

std::vector<std::uint8_t> drawn_styles(const DrawInput& input) {
  std::vector<std::uint8_t> drawn;
  for (const IntervalStyle& style : input.styles) drawn.push_back(is_drawn(style));
  return drawn;
}

std::vector<DrawGroup> groups_of(const DrawInput& input) {
  std::map<int, DrawGroup> by_priority;
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    const IntervalStyle& style = input.styles[i];
    if (!is_drawn(style)) continue;
    const int priority = input.mode == RenderMode::prioritized ? style.priority : 0;
    const auto [entry, fresh] = by_priority.try_emplace(priority);
    DrawGroup& group = entry->second;
    if (fresh) {
      group.priority = priority;
      group.members.assign(input.styles.size(), 0);
      group.color = style.color;
    }
    group.members[i] = 1;
    group.one_color = group.one_color && group.color == style.color && !style.surface.drawn();
  }
  std::vector<DrawGroup> groups;
  for (auto& [priority, group] : by_priority) groups.push_back(std::move(group));
  return groups;
}

struct TileScratch {
  TilePixels pixels;
  std::vector<TileEntry> entries;
  OpticalDepthTile sums;
  CrossingListTile lists;
};

void draw_tile(const CrossingFrame& frame, std::size_t tile, TileScratch& scratch, TileSink& sink) {
  const auto column = static_cast<int>(tile) % frame.bins.columns, row = static_cast<int>(tile) / frame.bins.columns;
  TilePixels& pixels = scratch.pixels;
  pixels.rect = {column * kTileWidth, row * kTileHeight, std::min((column + 1) * kTileWidth, frame.transform.width),
                 std::min((row + 1) * kTileHeight, frame.transform.height)};
  for (std::vector<float>& plane : pixels.planes) plane.assign(kTilePixels + kWalkPadding, 0);
  const bool wants_depth = sink.wants_depth(), wants_mean_depth = sink.wants_mean_depth();
  if (wants_depth) pixels.depth.assign(kTilePixels, std::numeric_limits<float>::infinity());
  pixels.mean_depth.assign(wants_mean_depth ? kTilePixels + kWalkPadding : 0, 0);
  const std::span<const TileEntry> entries = frame.bins.tile(tile);
  const bool clipped = !frame.input.clip_planes.empty();
  pixels.nearest.clear();
  pixels.farthest.clear();
  if (clipped && !entries.empty()) {
    pixels.nearest.resize(kTilePixels + kWalkPadding);
    pixels.farthest.resize(kTilePixels + kWalkPadding);
    limit_rays(frame.transform, frame.input.clip_planes, pixels.rect, kTileWidth, pixels.nearest.data(), pixels.farthest.data());
  }
  for (const DrawGroup& group : frame.groups) {
    std::span<const TileEntry> own = entries;
    if (frame.groups.size() > 1) {
      scratch.entries.clear();
      for (const TileEntry& entry : entries)
        if (group.members[entry.interval]) scratch.entries.push_back(entry);
      own = scratch.entries;
    }
    if (own.empty()) continue;
    if (group.one_color && !(wants_depth && clipped) && !wants_mean_depth)
      scratch.sums.draw(frame, group, own, wants_depth, pixels);
    else
      scratch.lists.draw(frame, own, wants_depth, pixels);
  }
  FinishedTile finished;
  finished.x = pixels.rect.x0;
  finished.y = pixels.rect.y0;
  finished.width = pixels.rect.x1 - pixels.rect.x0;
  finished.height = pixels.rect.y1 - pixels.rect.y0;
  finished.stride = kTileWidth;
  for (std::size_t c = 0; c < 4; ++c) finished.rgba[c] = pixels.planes[c].data();
  finished.depth = wants_depth ? pixels.depth.data() : nullptr;
  finished.mean_depth = wants_mean_depth ? pixels.mean_depth.data() : nullptr;
  sink.put(finished);
}

}  // namespace

struct CrossingsRenderer::State {
  std::weak_ptr<const IntervalMesh> mesh;  // whose facets are kept: by the control block's identity
  const IntervalMesh* made_for = nullptr;
  FacetSet set;
  Buffer<ScreenVertex> vertices;  // the memory of the last frame's
  Buffer<Vec3f> normals;          // of facets, likewise
  bool normals_are_of_set = false;
  int drawn = 0;  // how often the set was, lit so

  const FacetSet& facets_of(const std::shared_ptr<const IntervalMesh>& of) {
    if (made_for == of.get() && mesh.lock() == of) return set;
    made_for = nullptr;
    normals_are_of_set = false;
    drawn = 0;
    set = make_facet_set(*of);
    mesh = of;
    made_for = of.get();
    return set;
  }
};

CrossingsRenderer::CrossingsRenderer() : state_(std::make_unique<State>()) {}
CrossingsRenderer::~CrossingsRenderer() = default;

struct CrossingsRenderer::Facets {
  const FacetSet& set;
  ScreenTransform transform;
  double ms = 0;  // to find them
};

void CrossingsRenderer::draw(const DrawInput& input, TileSink& sink, DrawFacts& facts) {
  if (!input.bricks) {
    const FacetSet& set = state_->facets_of(input.mesh);
    return draw(input, {set, make_screen_transform(input, set.points.empty() ? Box3d{{0, 0, 0}, {0, 0, 0}} : set.bounds)}, sink, facts);
  }
  const Stopwatch watch;
  const ScreenTransform transform = make_screen_transform(input, input.bounds);
  DrawInput seen = input;
  auto mesh = std::make_shared<IntervalMesh>(seen_facets(*input.bricks, input.mesh->summaries, transform, drawn_styles(input)));
  if (lit_along_gradient(input))
    seen.normals = std::make_shared<const std::vector<Vec3f>>(gradient_normals(input.bricks->grid(), input.bricks->array(), *mesh, Task{}));
  const FacetSet set = make_facet_set(*mesh, FacetsAre::part);
  seen.mesh = std::move(mesh);
  draw(seen, {set, transform, watch.elapsed_ms()}, sink, facts);
}

void CrossingsRenderer::draw(const DrawInput& input, const Facets& of, TileSink& sink, DrawFacts& facts) {
  const FacetSet& set = of.set;
  const ScreenTransform& transform = of.transform;
  Stopwatch watch;
  const std::vector<std::uint8_t> drawn = drawn_styles(input);
  Buffer<ScreenVertex>& vertices = state_->vertices;
  project_vertices(input.mesh->positions, transform, vertices);
  const FacetBins bins = bin_facets(set, *input.mesh, vertices, transform, drawn);
  CrossingFrame frame{input, set, bins, transform, vertices, groups_of(input)};
  const double unit = input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal());
  for (const IntervalStyle& style : input.styles) {
    frame.extinction.push_back(static_cast<float>(extinction(style.opacity, unit) * transform.scale));
    frame.materials.push_back(style.visible && style.surface.drawn() ? std::optional(surface_material(style.surface))
                                                                     : std::nullopt);
  }
  frame.tables = make_ray_tables(frame);
  if (frame.tables.any_surface && !input.normals) {
    const bool kept = &set == &state_->set;
    // Once for each facet if that is less than once for each crossing, or if there have been pictures of the same facets as when a camera turns.
    constexpr int kTurns = 3;  // more than there are pictures of one pixel's rays at rest
    const bool pays = set.points.size() <= static_cast<std::size_t>(transform.width) * static_cast<std::size_t>(transform.height) || (kept && state_->drawn >= kTurns);
    if (pays && !(kept && state_->normals_are_of_set)) facet_normals(set, *input.mesh, state_->normals);
    if (pays) frame.normals = state_->normals;
    state_->normals_are_of_set = kept && pays;
    state_->drawn = kept ? std::min(state_->drawn + 1, kTurns) : 0;
  }
  if (sink.rounded()) {
    frame.least_through = kLeastThrough;
    frame.most_unlit = kMostUnlit;
  }
  facts.order_ms = of.ms + watch.lap_ms();

  parallel_for(static_cast<std::int64_t>(bins.first.size()) - 1, 1, [&](std::int64_t begin, std::int64_t end) {
    thread_local TileScratch scratch;
    for (std::int64_t t = begin; t < end; ++t) draw_tile(frame, static_cast<std::size_t>(t), scratch, sink);
  });
  facts.draw_ms = watch.lap_ms();

  const bool no_order = std::all_of(frame.groups.begin(), frame.groups.end(), [](const DrawGroup& g) { return g.one_color; });
  facts.order = no_order ? "none needed" : "per pixel (exact)";
  if (input.mode == RenderMode::prioritized)
    facts.order = no_order ? "priority (none needed)" : "priority, then per pixel (exact)";
  facts.order_exact = true;
  facts.tetrahedra = 0;
  for (std::size_t i = 0; i < input.styles.size(); ++i)
    if (drawn[i]) facts.tetrahedra += input.mesh->summaries[i].tetrahedra;
  if (input.count_fragments && !input.bricks) facts.fragments = count_fragments(*input.mesh, vertices, transform, drawn);
}

}  // namespace isostrata
