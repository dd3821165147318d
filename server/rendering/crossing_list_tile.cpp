#include "rendering/crossing_list_tile.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace isostrata {
namespace {

constexpr std::size_t kPixels = static_cast<std::size_t>(kTileWidth) * kTileHeight;
static_assert(kPixels <= 1 << 16);
constexpr std::size_t kMaxCrossings = std::size_t{1} << 22;  // of a part of a tile that has more than one pixel

float depth_of(std::uint64_t key) {
  const auto bits = static_cast<std::uint32_t>(key >> 32);
  return std::bit_cast<float>(bits & 0x80000000u ? bits & 0x7fffffffu : ~bits);
}
std::uint32_t facet_of(std::uint64_t key) { return static_cast<std::uint32_t>(key) & 0x7fffffffu; }
bool enters(std::uint64_t key) { return key >> 31 & 1; }

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

/// 1 - exp(-depth), to 2e-7. Between two crossings of thin layers depths are small, and the library's function the dearest step.
float opacity_of(float depth) {
  if (!(std::abs(depth) < 0.5f)) return -std::expm1(-depth);
  float sum = 1;
  for (const float over : {1.0f / 7, 1.0f / 6, 1.0f / 5, 1.0f / 4, 1.0f / 3, 1.0f / 2}) sum = 1 - depth * over * sum;
  return depth * sum;
}

bool draws(const SurfaceStyle& surface, FacetLabel label) {
  return label == FacetLabel::lower ? surface.lower : label == FacetLabel::upper ? surface.upper : surface.domain;
}

/// The surface where the pixel's ray crosses the facet.
SurfaceColor shade(const CrossingFrame& frame, std::uint32_t facet, std::uint16_t interval, int x, int y) {
  const DrawInput& input = frame.input;
  const auto& points = frame.set.points[facet];
  const Vec3d a = input.mesh->positions[points[0]], b = input.mesh->positions[points[1]], c = input.mesh->positions[points[2]];
  // The ray in world space. view_from_world's rows are the camera's axes.
  const auto& m = frame.transform.view_from_world.m;
  const auto to_world = [&](Vec3d v) {
    return Vec3d{m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                 m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
  };
  const ViewPoint ray = frame.transform.ray(x + 0.5, y + 0.5);
  Vec3d origin = input.camera.eye, direction;
  if (frame.transform.orthographic) {
    origin = origin + to_world({ray.x, ray.y, 0}) * frame.transform.scale;
    direction = to_world({0, 0, -1});
  } else {
    direction = normalized(to_world({ray.x, ray.y, -1}));
  }
  const auto single = [](Vec3d v) { return Vec3f{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; };
  double weight[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
  if (input.normals || input.texture_values) {
    const Vec3d p = a - origin, q = b - origin, r = c - origin;
    const double w0 = dot(direction, cross(q, r)), w1 = dot(direction, cross(r, p)), w2 = dot(direction, cross(p, q));
    const double sum = w0 + w1 + w2;
    if (sum != 0) {
      const auto share = [&](double w) { return std::clamp(w / sum, 0.0, 1.0); };
      weight[0] = share(w0), weight[1] = share(w1), weight[2] = share(w2);
    }
  }
  const Vec3d across = cross(b - a, c - a);
  const double size = length(across);
  const Vec3d own_normal = size > 0 ? across / size : Vec3d{};
  Vec3d normal = own_normal;
  if (input.normals) {
    normal = {};
    for (std::size_t v = 0; v < 3; ++v) {
      const Vec3f n = (*input.normals)[points[v]];
      normal = normal + Vec3d{n.x, n.y, n.z} * weight[v];
    }
  }
  double value = 0;
  if (input.texture_values)
    for (std::size_t v = 0; v < 3; ++v) value += weight[v] * (*input.texture_values)[points[v]];
  return shade_surface(*frame.materials[interval], input.styles[interval].color, single(normal), single(own_normal), single(direction * -1.0),
                       static_cast<float>(value));
}

}  // namespace

/// What a ray has gathered so far.
struct CrossingListTile::Ray {
  float color[3] = {};
  float through = 1;

  void add(const float* premultiplied, float alpha) {
    for (std::size_t c = 0; c < 3; ++c) color[c] += through * premultiplied[c];
    through *= 1 - alpha;
  }
};

void CrossingListTile::sort_by_pixel() {
  const std::size_t count = records_.count;
  for (std::size_t i = 0; i < count; ++i) ++first_[records_.pixels[i] + 1u];
  for (std::size_t p = 1; p < first_.size(); ++p) first_[p] += first_[p - 1];
  if (sorted_.size() < count) sorted_.resize(count);
  for (std::size_t i = 0; i < count; ++i) sorted_[first_[records_.pixels[i]]++] = records_.keys[i];
  for (std::size_t p = first_.size() - 1; p > 0; --p) first_[p] = first_[p - 1];
  first_[0] = 0;
}

void CrossingListTile::open(std::uint16_t interval, int change) {
  for (std::size_t i = 0; i < open_.size(); ++i) {
    if (open_[i].interval != interval) continue;
    open_[i].count += change;
    if (open_[i].count == 0) {
      open_[i] = open_.back();
      open_.pop_back();
    }
    return;
  }
  open_.push_back({interval, change});
}

void CrossingListTile::walk(const CrossingFrame& frame, int x, int y, std::span<const std::uint64_t> crossings, bool wants_depth,
                            TilePixels& tile) {
  const std::size_t pixel = static_cast<std::size_t>(y - tile.rect.y0) * kTileWidth + static_cast<std::size_t>(x - tile.rect.x0);
  const ScreenTransform& transform = frame.transform;
  float nearest = -std::numeric_limits<float>::infinity(), farthest = std::numeric_limits<float>::infinity();
  if (!tile.nearest.empty()) {
    nearest = tile.nearest[pixel];
    farthest = tile.farthest[pixel];
    if (!(nearest < farthest)) return;
  } else if (!transform.orthographic) {
    nearest = static_cast<float>(transform.near_depth - transform.reference);
  }
  open_.clear();
  if (frame.bins.too_near)  // else every ray begins outside
    for (const std::uint64_t key : crossings) open(frame.set.intervals[facet_of(key)], enters(key) ? -1 : 1);
  const auto stretch = static_cast<float>(transform.stretch(x + 0.5, y + 0.5));
  Ray ray;
  float first = std::numeric_limits<float>::infinity();
  float at = nearest;
  for (const std::uint64_t key : crossings) {
    const float z = depth_of(key), to = std::clamp(z, nearest, farthest);
    if (!open_.empty() && to > at) {
      float extinction = 0, mixed[3] = {};
      for (const Open& o : open_) {
        const float own = static_cast<float>(o.count) * frame.extinction[o.interval];
        extinction += own;
        for (std::size_t c = 0; c < 3; ++c) mixed[c] += own * frame.input.styles[o.interval].color[c];
      }
      if (extinction != 0 && (extinction > 0 || open_.size() == 1)) {
        const float alpha = opacity_of(extinction * (to - at) * stretch);
        for (float& c : mixed) c *= alpha / extinction;
        ray.add(mixed, alpha);
        first = std::min(first, at);
      }
    }
    at = std::max(at, to);
    const std::uint32_t facet = facet_of(key);
    const std::uint16_t interval = frame.set.intervals[facet];
    if (frame.materials[interval] && z >= nearest && z <= farthest &&
        draws(frame.input.styles[interval].surface, frame.set.labels[facet])) {
      const SurfaceColor surface = shade(frame, facet, interval, x, y);
      ray.add(surface.color.data(), surface.alpha);
      if (surface.alpha > 0) first = std::min(first, z);
    }
    open(interval, enters(key) ? 1 : -1);
  }
  for (std::size_t c = 0; c < 3; ++c) tile.planes[c][pixel] = ray.color[c] + ray.through * tile.planes[c][pixel];
  tile.planes[3][pixel] = 1 - ray.through + ray.through * tile.planes[3][pixel];
  if (wants_depth && first < std::numeric_limits<float>::infinity())
    tile.depth[pixel] = std::min(tile.depth[pixel], static_cast<float>((double{first} + transform.reference) * transform.scale));
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
  const auto width = static_cast<std::size_t>(part.x1 - part.x0), height = static_cast<std::size_t>(part.y1 - part.y0);
  first_.assign(width * height + 1, 0);
  sort_by_pixel();
  for (std::size_t p = 0; p < width * height; ++p) {
    const std::span<std::uint64_t> crossings(sorted_.data() + first_[p], sorted_.data() + first_[p + 1]);
    if (crossings.empty()) continue;
    sort_few(crossings);
    walk(frame, part.x0 + static_cast<int>(p % width), part.y0 + static_cast<int>(p / width), crossings, wants_depth, tile);
  }
  return static_cast<std::int64_t>(records_.count);
}

std::int64_t CrossingListTile::draw(const CrossingFrame& frame, std::span<const TileEntry> entries, bool wants_depth,
                                    TilePixels& tile) {
  return draw_part(frame, entries, wants_depth, tile.rect, tile);
}

}  // namespace isostrata
