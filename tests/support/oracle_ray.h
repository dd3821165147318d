// A pixel's ray, and where it is inside a tetrahedron or crosses a facet. Double precision, nothing clever.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "rendering/picture/renderer.h"

namespace isostrata::testing {

/// The points origin + t * direction, first <= t <= last: what the camera and the clip planes leave of a pixel's line.
struct OracleRay {
  Vec3d origin;
  Vec3d direction;  // of length 1, so that t is in world units
  double first = 0, last = std::numeric_limits<double>::infinity();
};

struct OracleSegment {
  double enter, leave;  // along the ray, world units
  std::size_t tetrahedron;
  double scalar_enter, scalar_leave;
};

/// Right, up and forward of the camera, each of length 1.
inline std::array<Vec3d, 3> oracle_frame(const Camera& camera) {
  const Vec3d forward = normalized(camera.at - camera.eye);
  const Vec3d right = normalized(cross(forward, normalized(camera.up)));
  return {right, cross(right, forward), forward};
}

/// The direction of pixel (x, y), y down, through its middle.
inline Vec3d oracle_direction(const DrawInput& input, double x, double y) {
  const auto [right, up, forward] = oracle_frame(input.camera);
  if (input.camera.orthographic) return forward;
  const double focal = 0.5 * input.height / std::tan(input.camera.fov_deg * std::numbers::pi / 360);
  return normalized(forward + right * ((x + 0.5 - 0.5 * input.width) / focal) + up * ((0.5 * input.height - y - 0.5) / focal));
}

/// The ray of pixel (x, y). An orthographic one has no beginning: what lies behind the eye is seen.
inline OracleRay oracle_ray(const DrawInput& input, double x, double y) {
  OracleRay ray{input.camera.eye, oracle_direction(input, x, y)};
  if (input.camera.orthographic) {
    const auto [right, up, forward] = oracle_frame(input.camera);
    const double pixel = 2 * half_height(input.camera) / input.height;
    ray.origin =
        input.camera.eye + right * ((x + 0.5 - 0.5 * input.width) * pixel) + up * ((0.5 * input.height - y - 0.5) * pixel);
    ray.first = -std::numeric_limits<double>::infinity();
  }
  for (const ClipPlane& plane : input.clip_planes) {
    const double along = dot(plane.normal, ray.direction), at = plane.offset - dot(plane.normal, ray.origin);
    if (along > 0)
      ray.first = std::max(ray.first, at / along);
    else if (along < 0)
      ray.last = std::min(ray.last, at / along);
    else if (at > 0)
      ray.last = -std::numeric_limits<double>::infinity();
  }
  return ray;
}

/// Where the ray is inside the tetrahedron. False if it misses or only touches. A tetrahedron of no volume is never met: its
/// faces' normals are noise.
inline bool oracle_segment(const IntervalMesh& mesh, const std::vector<float>* scalars, std::size_t tetrahedron,
                           const OracleRay& ray, OracleSegment& out) {
  const auto& ids = mesh.tetrahedra[tetrahedron];
  Vec3d p[4];
  for (std::size_t v = 0; v < 4; ++v) p[v] = mesh.positions[ids[v]] - ray.origin;
  const double volume = orient3d(p[0], p[1], p[2], p[3]);
  double longest2 = 0;
  for (const Vec3d& a : p)
    for (const Vec3d& b : p) longest2 = std::max(longest2, dot(a - b, a - b));
  if (!(volume * volume > 1e-20 * longest2 * longest2 * longest2)) return false;
  double enter = ray.first, leave = ray.last;
  for (int f = 0; f < 4; ++f) {
    const Vec3d a = p[(f + 1) % 4], b = p[(f + 2) % 4], c = p[(f + 3) % 4];
    Vec3d n = cross(b - a, c - a);
    if (dot(n, p[f] - a) > 0) n = n * -1.0;  // outwards
    const double along = dot(n, ray.direction), at = dot(n, a);
    if (along == 0) {
      if (at < 0) return false;
      continue;
    }
    const double t = at / along;
    if (along < 0)
      enter = std::max(enter, t);
    else
      leave = std::min(leave, t);
  }
  if (!(leave > enter) || !std::isfinite(leave - enter)) return false;
  out = {enter, leave, tetrahedron, 0, 0};
  if (scalars) {
    double value[4];
    for (std::size_t v = 0; v < 4; ++v) value[v] = (*scalars)[ids[v]];
    const auto* const least = std::min_element(value, value + 4);
    const auto* const most = std::max_element(value, value + 4);
    const auto scalar_at = [&](Vec3d x) {
      const double w0 = orient3d(x, p[1], p[2], p[3]), w1 = orient3d(p[0], x, p[2], p[3]), w2 = orient3d(p[0], p[1], x, p[3]),
                   w3 = orient3d(p[0], p[1], p[2], x);
      const double sum = w0 * value[0] + w1 * value[1] + w2 * value[2] + w3 * value[3];
      return std::clamp(sum / volume, *least, *most);  // slivers have few digits
    };
    out.scalar_enter = scalar_at(ray.direction * enter);
    out.scalar_leave = scalar_at(ray.direction * leave);
  }
  return true;
}

struct OracleCrossing {
  double at;                      // along the ray, world units
  std::size_t facet;              // in mesh.facets
  bool entering;                  // into the interval that the facet bounds
  std::array<double, 3> weights;  // of facet.points
};

/// Where the ray crosses the facet. Facets that share an edge are crossed by a ray through it once: the edge belongs to one side
/// whichever facet asks. Facets on the same three points are crossed at the same t to the last bit.
inline bool oracle_crossing(const IntervalMesh& mesh, std::size_t facet, const OracleRay& ray, OracleCrossing& out) {
  const auto& points = mesh.facets[facet].points;
  std::array<std::size_t, 3> order{0, 1, 2};  // by point id, so that the arithmetic is the same whoever owns the facet
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return points[a] < points[b]; });
  const bool odd = (order[0] > order[1]) != ((order[1] > order[2]) != (order[0] > order[2]));
  const Vec3d a = mesh.positions[points[order[0]]] - ray.origin, b = mesh.positions[points[order[1]]] - ray.origin,
              c = mesh.positions[points[order[2]]] - ray.origin;
  const double bc = dot(ray.direction, cross(b, c)), ac = dot(ray.direction, cross(a, c)), ab = dot(ray.direction, cross(a, b));
  if ((bc >= 0) == (ac >= 0) || (ac >= 0) == (ab >= 0)) return false;
  const double sum = bc - ac + ab;  // dot(direction, normal of a, b, c)
  if (sum == 0) return false;
  out.at = dot(cross(b - a, c - a), a) / sum;
  if (!(out.at >= ray.first && out.at <= ray.last)) return false;
  out.facet = facet;
  out.entering = (sum < 0) != odd;
  out.weights[order[0]] = bc / sum;
  out.weights[order[1]] = -ac / sum;
  out.weights[order[2]] = ab / sum;
  return true;
}

}  // namespace isostrata::testing
