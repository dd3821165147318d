#include "rendering/light/light_rows.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "rendering/light/light_simd.h"
#include "rendering/picture/pixel_grid.h"

namespace isostrata {
namespace {

constexpr int kPairs = 56;
constexpr double kOcclusionGain = 1.0;
constexpr std::int64_t kRows = 8;  // that a thread lights before it asks for more

/// Takes the first `rows` rows out of `from`.
FloatImage split(FloatImage& from, int rows) {
  const auto cut = [&](std::vector<float>& values, std::size_t each) {
    const auto end = values.begin() + static_cast<std::ptrdiff_t>(std::min(values.size(), each * static_cast<std::size_t>(rows) * static_cast<std::size_t>(from.width)));
    std::vector<float> first(values.begin(), end);
    values.erase(values.begin(), end);
    return first;
  };
  FloatImage first{from.width, rows, cut(from.rgba, 4), cut(from.depth, 1), cut(from.mean_depth, 1)};
  from.height -= rows;
  return first;
}

void append(FloatImage& to, FloatImage&& rows) {
  if (to.height == 0) {
    to = std::move(rows);
    return;
  }
  to.height += rows.height;
  to.rgba.insert(to.rgba.end(), rows.rgba.begin(), rows.rgba.end());
  to.depth.insert(to.depth.end(), rows.depth.begin(), rows.depth.end());
  to.mean_depth.insert(to.mean_depth.end(), rows.mean_depth.begin(), rows.mean_depth.end());
}

}  // namespace

std::vector<OcclusionPair> occlusion_pairs(int height) {
  const double radius = kOcclusionRadius * height;
  std::vector<OcclusionPair> pairs;
  double sum = 0;
  for (int i = 0; i < kPairs; ++i) {
    const double share = (i + 0.5) / kPairs, distance = radius * std::sqrt(share), angle = std::numbers::pi * std::numbers::phi * i;
    const OcclusionPair pair{static_cast<int>(std::lround(distance * std::cos(angle))), static_cast<int>(std::lround(distance * std::sin(angle))), 1 - 0.8 * share};
    sum += pair.weight;
    if (pair.dx != 0 || pair.dy != 0) pairs.push_back(pair);
  }
  for (OcclusionPair& pair : pairs) pair.weight *= kOcclusionGain / sum;
  return pairs;
}

DepthSpan depth_span(const Box3d& bounds, const Camera& camera) {
  const Vec3d forward = normalized(camera.at - camera.eye);
  DepthSpan span{INFINITY, -INFINITY};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at{corner & 1 ? bounds.upper.x : bounds.lower.x, corner & 2 ? bounds.upper.y : bounds.lower.y, corner & 4 ? bounds.upper.z : bounds.lower.z};
    const double depth = dot(at - camera.eye, forward);
    span.nearest = std::min(span.nearest, depth);
    span.farthest = std::max(span.farthest, depth);
  }
  if (!camera.orthographic) span.nearest = std::max(span.nearest, 0.0);
  return span;
}

LightRows::LightRows(const DepthLight& light, const DrawInput& whole)
    : width_(whole.width), height_(whole.height), light_(light), perspective_(!whole.camera.orthographic), span_(depth_span(whole.bounds, whole.camera)) {
  for (const auto& [name, value] : {std::pair{"occlusion", light.occlusion}, {"depth fade", light.fade}})
    if (!(value >= 0 && value <= 1))
      throw Error(ErrorCode::invalid_argument, std::string(name) + " is " + std::to_string(value) + "; expected a number from 0 to 1");
  if (light_.occlusion > 0) pairs_ = occlusion_pairs(height_);
  for (const OcclusionPair& pair : pairs_) margin_ = std::max({margin_, std::abs(pair.dx), std::abs(pair.dy)});
  const PixelGrid grid = pixel_grid(whole.camera, whole.width, whole.height);
  radius_ = kOcclusionRadius * height_ / (perspective_ ? grid.focal : grid.per_unit);
  stride_ = static_cast<std::size_t>(width_ + 2 * margin_);
  nothing_.resize(stride_);
}

void LightRows::add_depths(const FloatImage& rows) {
  const auto kept = static_cast<std::size_t>(taken_ - first_kept_), margin = static_cast<std::size_t>(margin_);
  depth_.resize((kept + static_cast<std::size_t>(rows.height)) * stride_);
  alpha_.resize(depth_.size());
  parallel_for(rows.height, 2 * kRows, [&](std::int64_t begin, std::int64_t end) {
    for (auto y = static_cast<std::size_t>(begin); y < static_cast<std::size_t>(end); ++y) {
      const std::size_t from = y * static_cast<std::size_t>(width_), to = (kept + y) * stride_ + margin;
      depth_row({&rows.rgba[4 * from], &rows.mean_depth[from], static_cast<std::size_t>(width_), &depth_[to], &alpha_[to]});
    }
  });
}

void LightRows::light(int begin, int end) {
  LitRow all;
  all.count = static_cast<std::size_t>(width_);
  all.radius = static_cast<float>(radius_);
  all.perspective = perspective_;
  all.darkest = static_cast<float>(kDarkestOcclusion * light_.occlusion);
  all.fade = static_cast<float>(light_.fade);
  all.nearest = static_cast<float>(span_.nearest);
  all.per_depth = span_.farthest > span_.nearest ? static_cast<float>(1 / (span_.farthest - span_.nearest)) : 0.0f;
  const auto row_of = [&](const std::vector<float>& plane, int y) {
    return y < 0 || y >= height_ ? nothing_.data() + margin_ : &plane[static_cast<std::size_t>(y - first_kept_) * stride_ + static_cast<std::size_t>(margin_)];
  };
  parallel_for(end - begin, kRows, [&](std::int64_t first, std::int64_t last) {
    std::vector<NeighbourPair> pairs(pairs_.size());
    for (int y = begin + static_cast<int>(first); y < begin + static_cast<int>(last); ++y) {
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        const auto [dx, dy, weight] = pairs_[i];
        pairs[i] = {row_of(depth_, y + dy) + dx, row_of(alpha_, y + dy) + dx, row_of(depth_, y - dy) - dx, row_of(alpha_, y - dy) - dx,
                    static_cast<float>(weight * light_.occlusion)};
      }
      LitRow row = all;
      row.depth = row_of(depth_, y);
      row.pairs = pairs;
      row.rgba = &waiting_.rgba[4 * static_cast<std::size_t>(y - done_) * static_cast<std::size_t>(width_)];
      light_row(row);
    }
  });
}

FloatImage LightRows::add(FloatImage&& rows) {
  add_depths(rows);
  taken_ += rows.height;
  append(waiting_, std::move(rows));
  const int ready = taken_ == height_ ? height_ : std::max(done_, taken_ - margin_);
  light(done_, ready);
  FloatImage lit = ready == taken_ ? std::exchange(waiting_, {width_, 0, {}, {}, {}}) : split(waiting_, ready - done_);
  done_ = ready;
  if (const int keep = std::max(first_kept_, done_ - margin_); keep > first_kept_) {
    const auto gone = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(keep - first_kept_) * stride_);
    depth_.erase(depth_.begin(), depth_.begin() + gone);
    alpha_.erase(alpha_.begin(), alpha_.begin() + gone);
    first_kept_ = keep;
  }
  return lit;
}

}  // namespace isostrata
