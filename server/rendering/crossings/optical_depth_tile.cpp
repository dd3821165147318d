#include "rendering/crossings/optical_depth_tile.h"

#include <algorithm>
#include <cmath>

#include "rendering/crossings/scan_simd.h"
#include "rendering/tiles/resolve_simd.h"

namespace isostrata {
namespace {

constexpr std::size_t kDepthPixels = static_cast<std::size_t>(kTileWidth) * kTileHeight;
constexpr int kIntervalsPerSum = 8;  // so many that lie over one another do not overflow
constexpr double kSteps = 1 << 27;   // for ScreenTransform::reach

}  // namespace

void OpticalDepthTile::take_up(const CrossingFrame& frame, float extinction, const TilePixels& tile, bool cut) {
  for (std::size_t i = 0; cut && i < kDepthPixels; ++i) {
    if (balance_[i] == 0) continue;  // else the ray begins inside
    const double nearest =
        tile.nearest.empty() ? frame.transform.near_depth - frame.transform.reference : double{tile.nearest[i]};
    sum_[i] -= balance_[i] * static_cast<std::int32_t>(std::lrint(static_cast<float>(nearest) * static_cast<float>(steps_)));
    if (balance_[i] > 0) first_[i] = static_cast<float>(nearest);
  }
  add_scaled(sum_.data(), static_cast<float>(extinction / steps_), kDepthPixels, optical_depth_.data());
}

void OpticalDepthTile::paint(const CrossingFrame& frame, const Rgb& color, bool wants_depth, TilePixels& tile) const {
  const ScreenTransform& transform = frame.transform;
  for (int y = tile.rect.y0; y < tile.rect.y1; ++y) {
    const std::size_t row = static_cast<std::size_t>(y - tile.rect.y0) * kTileWidth;
    const ViewPoint ray = transform.ray(tile.rect.x0 + 0.5, y + 0.5);
    const bool parallel = transform.orthographic;
    paint_row({&optical_depth_[row],
               static_cast<std::size_t>(tile.rect.x1 - tile.rect.x0),
               parallel ? 0.0f : static_cast<float>(ray.y * ray.y),
               parallel ? 0.0f : static_cast<float>(ray.x),
               parallel ? 0.0f : static_cast<float>(1 / transform.focal),
               color,
               {&tile.planes[0][row], &tile.planes[1][row], &tile.planes[2][row], &tile.planes[3][row]}});
  }
  if (!wants_depth) return;
  for (std::size_t i = 0; i < kDepthPixels; ++i)
    if (optical_depth_[i] > 0)
      tile.depth[i] = std::min(tile.depth[i], static_cast<float>((double{first_[i]} + transform.reference) * transform.scale));
}

std::int64_t OpticalDepthTile::draw(const CrossingFrame& frame, const DrawGroup& group, std::span<const TileEntry> entries,
                                    bool wants_depth, TilePixels& tile) {
  const bool cut = frame.bins.too_near || !tile.nearest.empty() || wants_depth;
  steps_ = kSteps / frame.transform.reach;
  optical_depth_.assign(kDepthPixels, 0);
  if (cut) first_.assign(kDepthPixels, std::numeric_limits<float>::infinity());
  std::int64_t crossings = 0;
  for (std::size_t begin = 0; begin < entries.size();) {
    std::size_t end = begin;
    const float extinction = frame.extinction[entries[begin].interval];
    for (int intervals = 0, last = -1; end < entries.size(); ++end) {
      if (frame.extinction[entries[end].interval] != extinction) break;
      if (entries[end].interval != last && ++intervals > kIntervalsPerSum) break;
      last = entries[end].interval;
    }
    sum_.assign(kDepthPixels + kDepthSumsPadding, 0);
    if (cut) balance_.assign(kDepthPixels, 0);
    const auto part = entries.subspan(begin, end - begin);
    DepthSums to{tile.rect, static_cast<float>(steps_), sum_.data()};
    if (cut) {
      to.balance = balance_.data();
      to.first = first_.data();
      if (!tile.nearest.empty()) {
        to.nearest = tile.nearest.data();
        to.farthest = tile.farthest.data();
      }
    }
    crossings += add_depths(frame, part, to);
    take_up(frame, extinction, tile, cut);
    begin = end;
  }
  paint(frame, group.color, wants_depth, tile);
  return crossings;
}

}  // namespace isostrata
