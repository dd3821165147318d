#include "engine/picture/ray_stretch.h"

#include <algorithm>
#include <cmath>

namespace isostrata {
namespace {

constexpr double kHair = 1e-9;  // of a corner's weight

/// What all corners but for a hair leave of [ray.first, ray.last].
std::optional<RayStretch> limited(RayStretch of, const ViewRay& ray) {
  of.enter = ray.first;
  of.leave = ray.last;
  for (std::size_t v = 0; v < of.corners; ++v) {
    if (!std::isfinite(of.at[v]) || !std::isfinite(of.along[v])) return std::nullopt;
    if (of.along[v] == 0) {
      if (of.at[v] < -kHair) return std::nullopt;
      continue;
    }
    const double t = (-kHair - of.at[v]) / of.along[v];
    if (of.along[v] > 0)
      of.enter = std::max(of.enter, t);
    else
      of.leave = std::min(of.leave, t);
  }
  if (!(of.leave > of.enter) || !std::isfinite(of.leave - of.enter)) return std::nullopt;
  return of;
}

}  // namespace

std::array<double, 4> RayStretch::weights(double t) const {
  std::array<double, 4> weights{};
  double sum = 0;
  for (std::size_t v = 0; v < corners; ++v) {
    const double weight = at[v] + t * along[v];
    sum += weights[v] = weight > 2 * kHair ? weight : 0;  // the corner across counts for nothing, since it may be NaN
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

std::optional<RayStretch> tetrahedron_stretch(const IntervalMesh& mesh, std::size_t tetrahedron, const ViewRay& ray) {
  RayStretch of;
  of.points = mesh.tetrahedra[tetrahedron];
  std::array<Vec3d, 4> p;
  for (std::size_t v = 0; v < 4; ++v) p[v] = mesh.positions[of.points[v]] - ray.origin;
  double longest2 = 0;
  for (std::size_t v = 1; v < 4; ++v) longest2 = std::max(longest2, dot(p[v] - p[0], p[v] - p[0]));
  const double volume = orient3d(p[0], p[1], p[2], p[3]);
  if (!(volume * volume > 1e-20 * longest2 * longest2 * longest2)) return std::nullopt;
  for (std::size_t v = 0; v < 4; ++v) {
    const Vec3d a = p[(v + 1) % 4], normal = cross(p[(v + 2) % 4] - a, p[(v + 3) % 4] - a);
    const double height = dot(normal, p[v] - a);
    of.at[v] = -dot(normal, a) / height;
    of.along[v] = dot(normal, ray.direction) / height;
  }
  return limited(of, ray);
}

std::optional<RayStretch> triangle_stretch(const IntervalMesh& mesh, std::size_t facet, const ViewRay& ray) {
  RayStretch of;
  of.corners = 3;
  const auto& ids = mesh.facets[facet].points;
  of.points = {ids[0], ids[1], ids[2], ids[0]};
  std::array<Vec3d, 3> p;
  for (std::size_t v = 0; v < 3; ++v) p[v] = mesh.positions[ids[v]] - ray.origin;
  const Vec3d normal = cross(p[1] - p[0], p[2] - p[0]);
  const double square = dot(normal, normal);
  if (!(square > 0)) return std::nullopt;
  for (std::size_t v = 0; v < 3; ++v) {
    const Vec3d b = p[(v + 1) % 3], side = p[(v + 2) % 3] - b;
    of.at[v] = -dot(normal, cross(side, b)) / square;
    of.along[v] = dot(normal, cross(side, ray.direction)) / square;
  }
  const double size = std::sqrt(std::sqrt(square)), up = dot(normal, ray.direction) / std::sqrt(square);
  const double above = dot(normal, p[0]) / std::sqrt(square);
  if (std::abs(up) < kHair) return std::abs(above) < 1e-6 * size ? limited(of, ray) : std::nullopt;
  const double t = above / up;
  if (t < ray.first || t > ray.last) return std::nullopt;
  for (std::size_t v = 0; v < 3; ++v)
    if (of.at[v] + t * of.along[v] < -kHair) return std::nullopt;
  of.enter = of.leave = t;
  return of;
}

}  // namespace isostrata
