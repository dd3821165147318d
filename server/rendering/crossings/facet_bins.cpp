#include "rendering/crossings/facet_bins.h"

#include <algorithm>
#include <utility>

#include "base/parallel.h"
#include "rendering/crossings/facet_spans.h"

namespace isostrata {
namespace {

constexpr std::size_t kChunksPerBlock = 128;
constexpr int kTilesPerChunk = 6;  // a chunk over more tiles is looked at facet by facet

struct TileRange {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int count() const { return std::max(x1 - x0, 0) * std::max(y1 - y0, 0); }
};

class Binner {
 public:
  Binner(const FacetSet& set, const IntervalMesh& mesh, std::span<const ScreenVertex> vertices, const ScreenTransform& transform,
         FacetBins& bins)
      : set_(set), mesh_(mesh), vertices_(vertices), transform_(transform), bins_(bins) {}

  struct Block {
    std::vector<std::pair<std::uint32_t, TileEntry>> entries;  // tile, entry; clipped ones counted from this block's first
    std::vector<ClippedFacet> clipped;
    bool too_near = false;
  };

  void chunk(const FacetChunk& chunk, Block& block) const {
    int outside = 0;
    const TileRange tiles = bounds_on_screen(chunk.bounds, outside, block);
    if (outside == kCulled) return;
    if (outside == 0 && tiles.count() <= kTilesPerChunk) {
      put(tiles, {chunk.first, chunk.end, chunk.interval, 0}, block);
      return;
    }
    for (std::uint32_t f = chunk.first; f < chunk.end; ++f) facet(f, chunk.interval, block);
  }

 private:
  static constexpr int kCulled = -1;

  TileRange tiles_of(std::int32_t x_low, std::int32_t x_high, std::int32_t y_low, std::int32_t y_high) const {
    const int x0 = std::max(first_center(x_low), 0), x1 = std::min(first_center(x_high), transform_.width);
    const int y0 = std::max(first_center(y_low), 0), y1 = std::min(first_center(y_high), transform_.height);
    if (x0 >= x1 || y0 >= y1) return {};
    return {x0 / kTileWidth, y0 / kTileHeight, (x1 - 1) / kTileWidth + 1, (y1 - 1) / kTileHeight + 1};
  }

  /// outside: kCulled where nothing of the box is on the picture, 1 if a part of it cannot be projected.
  TileRange bounds_on_screen(const Box3d& box, int& outside, Block& block) const {
    std::int32_t x_low = 0, x_high = 0, y_low = 0, y_high = 0;
    int common = ~0, odd = 0;
    const double left = -transform_.axis_x / transform_.focal, right = (transform_.width - transform_.axis_x) / transform_.focal;
    const double above = transform_.axis_y / transform_.focal, below = (transform_.axis_y - transform_.height) / transform_.focal;
    for (int corner = 0; corner < 8; ++corner) {
      const ViewPoint p = transform_.view({corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                                           corner & 4 ? box.upper.z : box.lower.z});
      const double depth = transform_.orthographic ? 1 : p.z;
      // Against the pyramid of view, whose sides pass through the eye: right for points behind it, too.
      const bool too_near = p.z < transform_.near_depth;
      common &= (too_near ? 1 : 0) | (p.x < left * depth ? 2 : 0) | (p.x > right * depth ? 4 : 0) |
                (p.y < below * depth ? 8 : 0) | (p.y > above * depth ? 16 : 0);
      if (too_near) block.too_near = true;
      const ScreenVertex v = transform_.project(p);
      if (v.q == 0) {
        odd = 1;
        continue;
      }
      if (corner == 0 || v.x < x_low) x_low = v.x;
      if (corner == 0 || v.x > x_high) x_high = v.x;
      if (corner == 0 || v.y < y_low) y_low = v.y;
      if (corner == 0 || v.y > y_high) y_high = v.y;
    }
    outside = common != 0 ? kCulled : odd;
    // One step wider each way: the corners are rounded, and so are the points.
    return odd != 0 ? TileRange{} : tiles_of(x_low - 2, x_high + 2, y_low - 2, y_high + 2);
  }

  void put(const TileRange& tiles, const TileEntry& entry, Block& block) const {
    for (int y = tiles.y0; y < tiles.y1; ++y)
      for (int x = tiles.x0; x < tiles.x1; ++x)
        block.entries.emplace_back(static_cast<std::uint32_t>(y * bins_.columns + x), entry);
  }

  TileRange tiles_of(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c) const {
    return tiles_of(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}));
  }

  void facet(std::uint32_t f, std::uint16_t interval, Block& block) const {
    const auto& p = set_.points[f];
    const ScreenVertex &a = vertices_[p[0]], &b = vertices_[p[1]], &c = vertices_[p[2]];
    if (a.q != 0 && b.q != 0 && c.q != 0) {
      put(tiles_of(a, b, c), {f, f + 1, interval, 0}, block);
      return;
    }
    std::vector<ScreenTriangle> pieces;
    clip_facet(
        transform_,
        {transform_.view(mesh_.positions[p[0]]), transform_.view(mesh_.positions[p[1]]), transform_.view(mesh_.positions[p[2]])},
        {a, b, c}, pieces);
    for (const ScreenTriangle& piece : pieces) {
      const auto at = static_cast<std::uint32_t>(block.clipped.size());
      put(tiles_of(piece[0], piece[1], piece[2]), {at, at + 1, interval, 1}, block);
      block.clipped.push_back({piece, f});
    }
  }

  const FacetSet& set_;
  const IntervalMesh& mesh_;
  const std::span<const ScreenVertex> vertices_;
  const ScreenTransform& transform_;
  const FacetBins& bins_;
};

}  // namespace

FacetBins bin_facets(const FacetSet& set, const IntervalMesh& mesh, std::span<const ScreenVertex> vertices,
                     const ScreenTransform& transform, std::span<const std::uint8_t> drawn) {
  FacetBins bins;
  bins.columns = (transform.width + kTileWidth - 1) / kTileWidth;
  bins.rows = (transform.height + kTileHeight - 1) / kTileHeight;
  const Binner binner(set, mesh, vertices, transform, bins);
  std::vector<Binner::Block> blocks((set.chunks.size() + kChunksPerBlock - 1) / kChunksPerBlock);
  parallel_for(static_cast<std::int64_t>(blocks.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b)
      for (std::size_t c = b * kChunksPerBlock; c < std::min(set.chunks.size(), (b + 1) * kChunksPerBlock); ++c)
        if (drawn[set.chunks[c].interval]) binner.chunk(set.chunks[c], blocks[b]);
  });

  // By tile, blocks in their order: within a tile entries stay by interval, as chunks are.
  bins.first.assign(static_cast<std::size_t>(bins.columns) * static_cast<std::size_t>(bins.rows) + 1, 0);
  for (const Binner::Block& block : blocks) {
    bins.too_near = bins.too_near || block.too_near;
    for (const auto& [tile, entry] : block.entries) ++bins.first[tile + 1];
  }
  for (std::size_t t = 1; t < bins.first.size(); ++t) bins.first[t] += bins.first[t - 1];
  bins.entries.resize(bins.first.back());
  std::vector<std::uint32_t> next(bins.first.begin(), bins.first.end() - 1);
  for (const Binner::Block& block : blocks) {
    const auto before = static_cast<std::uint32_t>(bins.clipped.size());
    for (const auto& [tile, entry] : block.entries) {
      TileEntry& to = bins.entries[next[tile]++];
      to = entry;
      if (entry.clipped) {
        to.first += before;
        to.end += before;
      }
    }
    bins.clipped.insert(bins.clipped.end(), block.clipped.begin(), block.clipped.end());
  }
  return bins;
}

}  // namespace isostrata
