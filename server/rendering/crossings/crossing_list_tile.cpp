#include "rendering/crossings/crossing_list_tile.h"

#include <algorithm>

#include "rendering/crossings/walk_simd.h"

namespace isostrata {
namespace {

constexpr std::size_t kPixels = static_cast<std::size_t>(kTileWidth) * kTileHeight;
static_assert(kPixels <= 1 << 16);
constexpr std::size_t kMaxCrossings = std::size_t{1} << 22;  // of a part of a tile that has more than one pixel

/// Most pixels have a few crossings, and many of these in order.
void sort_few(std::span<std::uint64_t> keys) {
  if (keys.size() > 32) {
    std::sort(keys.begin(), keys.end());
    return;
  }
  for (std::size_t i = 1; i < keys.size(); ++i) {
    const std::uint64_t key = keys[i];
    std::size_t to = i;
    for (; to > 0 && keys[to - 1] > key; --to) keys[to] = keys[to - 1];
    keys[to] = key;
  }
}

}  // namespace

void CrossingListTile::sort_by_pixel(std::size_t pixels) {
  const std::size_t count = records_.count;
  first_.assign(pixels + 1 + kWalkPadding, 0);
  for (std::size_t i = 0; i < count; ++i) ++first_[records_.pixels[i] + 1u];
  for (std::size_t p = 1; p < first_.size(); ++p) first_[p] += first_[p - 1];
  if (sorted_.size() < count) sorted_.resize(count);
  for (std::size_t i = 0; i < count; ++i) sorted_[first_[records_.pixels[i]]++] = records_.keys[i];
  for (std::size_t p = pixels; p > 0; --p) first_[p] = first_[p - 1];
  first_[0] = 0;
  for (std::size_t p = 0; p < pixels; ++p) sort_few(std::span(sorted_).subspan(first_[p], first_[p + 1] - first_[p]));
}

std::int64_t CrossingListTile::draw_part(const CrossingFrame& frame, std::span<const TileEntry> entries, bool wants_depth,
                                         const PixelRect& part, TilePixels& tile) {
  const bool may_split = part.x1 - part.x0 > 1 || part.y1 - part.y0 > 1;
  if (!gather_crossings(frame, entries, part, may_split ? kMaxCrossings : ~std::size_t{0}, records_)) {
    PixelRect halves[2] = {part, part};
    if (part.x1 - part.x0 > part.y1 - part.y0)
      halves[0].x1 = halves[1].x0 = (part.x0 + part.x1) / 2;
    else
      halves[0].y1 = halves[1].y0 = (part.y0 + part.y1) / 2;
    return draw_part(frame, entries, wants_depth, halves[0], tile) + draw_part(frame, entries, wants_depth, halves[1], tile);
  }
  const int width = part.x1 - part.x0;
  sort_by_pixel(static_cast<std::size_t>(width) * static_cast<std::size_t>(part.y1 - part.y0));
  for (int y = part.y0; y < part.y1; ++y) {
    const std::size_t at =
        static_cast<std::size_t>(y - tile.rect.y0) * kTileWidth + static_cast<std::size_t>(part.x0 - tile.rect.x0);
    WalkRow row{frame, part.x0, y, width, sorted_.data(), &first_[static_cast<std::size_t>((y - part.y0) * width)]};
    if (!tile.nearest.empty()) {
      row.nearest = &tile.nearest[at];
      row.farthest = &tile.farthest[at];
    }
    for (std::size_t c = 0; c < 4; ++c) row.rgba[c] = &tile.planes[c][at];
    if (wants_depth) row.depth = &tile.depth[at];
    if (!tile.mean_depth.empty()) row.mean_depth = &tile.mean_depth[at];
    walk_row(row);
  }
  return static_cast<std::int64_t>(records_.count);
}

std::int64_t CrossingListTile::draw(const CrossingFrame& frame, std::span<const TileEntry> entries, bool wants_depth,
                                    TilePixels& tile) {
  return draw_part(frame, entries, wants_depth, tile.rect, tile);
}

}  // namespace isostrata
