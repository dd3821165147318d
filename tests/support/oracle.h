// The picture as it should be, slowly: in double precision, each pixel's ray through every tetrahedron, segments in their exact
// order along the ray, the exact integral of each. The renderers are measured against it.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "rendering/renderer.h"

namespace isostrata::testing {

struct OracleSegment {
  double enter, leave;  // along the ray, world units
  std::size_t tetrahedron;
  double scalar_enter, scalar_leave;
};

/// Where the ray eye + t * direction (unit length), t >= 0, is inside the tetrahedron. False where it misses or only touches.
inline bool oracle_segment(const IntervalMesh& mesh, const std::vector<float>* scalars, std::size_t tetrahedron, Vec3d eye,
                           Vec3d direction, OracleSegment& out) {
  const auto& ids = mesh.tetrahedra[tetrahedron];
  Vec3d p[4];
  for (std::size_t v = 0; v < 4; ++v) p[v] = mesh.positions[ids[v]] - eye;
  double enter = 0, leave = 1e300;
  for (int f = 0; f < 4; ++f) {
    const Vec3d a = p[(f + 1) % 4], b = p[(f + 2) % 4], c = p[(f + 3) % 4];
    Vec3d n = cross(b - a, c - a);
    if (dot(n, p[f] - a) > 0) n = n * -1.0;  // outwards
    const double along = dot(n, direction), at = dot(n, a);
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
  if (!(leave > enter)) return false;
  out = {enter, leave, tetrahedron, 0, 0};
  if (scalars) {
    const double volume = orient3d(p[0], p[1], p[2], p[3]);
    const auto scalar_at = [&](Vec3d x) {
      const double w0 = orient3d(x, p[1], p[2], p[3]), w1 = orient3d(p[0], x, p[2], p[3]), w2 = orient3d(p[0], p[1], x, p[3]),
                   w3 = orient3d(p[0], p[1], p[2], x);
      return (w0 * (*scalars)[ids[0]] + w1 * (*scalars)[ids[1]] + w2 * (*scalars)[ids[2]] + w3 * (*scalars)[ids[3]]) / volume;
    };
    out.scalar_enter = scalar_at(direction * enter);
    out.scalar_leave = scalar_at(direction * leave);
  }
  return true;
}

/// The ray of pixel (x, y), y down, through its middle.
inline Vec3d oracle_direction(const DrawInput& input, double x, double y) {
  const Vec3d forward = normalized(input.camera.at - input.camera.eye);
  const Vec3d right = normalized(cross(forward, input.camera.up)), up = cross(right, forward);
  const double focal = 0.5 * input.height / std::tan(input.camera.fov_deg * std::numbers::pi / 360);
  return normalized(forward + right * ((x + 0.5 - 0.5 * input.width) / focal) + up * ((0.5 * input.height - y - 0.5) / focal));
}

/// Premultiplied colour and alpha of one pixel, RenderMode::sorted.
inline std::array<double, 4> oracle_pixel(const DrawInput& input, int x, int y) {
  const Vec3d direction = oracle_direction(input, x, y);
  const std::vector<float>* scalars = input.color_values.get();
  std::vector<OracleSegment> segments;
  for (std::size_t t = 0; t < input.mesh->tetrahedra.size(); ++t) {
    OracleSegment segment{};
    if (input.styles[input.mesh->tetrahedron_interval[t]].visible &&
        oracle_segment(*input.mesh, scalars, t, input.camera.eye, direction, segment))
      segments.push_back(segment);
  }
  std::sort(segments.begin(), segments.end(),
            [](const OracleSegment& a, const OracleSegment& b) { return a.enter + a.leave < b.enter + b.leave; });
  const double unit = input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal());
  std::array<double, 4> sum{};
  double through = 1;
  for (const OracleSegment& s : segments) {
    const IntervalStyle& style = input.styles[input.mesh->tetrahedron_interval[s.tetrahedron]];
    const double tau = extinction(style.opacity, unit) * (s.leave - s.enter);
    const double alpha = -std::expm1(-tau);
    const double back = tau > 1e-6 ? alpha / tau - (1 - alpha) : tau / 2;
    Rgb front_color = style.color, back_color = style.color;
    if (!style.color_map.empty()) {
      const auto map = [&](double scalar) {
        return sample(color_map(style.color_map),
                      static_cast<float>((scalar - style.color_lower) / (style.color_upper - style.color_lower)));
      };
      front_color = map(s.scalar_enter);
      back_color = map(s.scalar_leave);
    }
    for (std::size_t c = 0; c < 3; ++c) sum[c] += through * ((alpha - back) * front_color[c] + back * back_color[c]);
    sum[3] += through * alpha;
    through *= 1 - alpha;
  }
  return sum;
}

struct OracleError {
  double max = 0, mean = 0;
  int max_x = 0, max_y = 0;
  double covered = 0;          // the share of pixels with some opacity
  double above_a_percent = 0;  // the share of channel values that differ by more than 0.01
};

/// The picture's error against the oracle, over all pixels and channels.
inline OracleError compare_with_oracle(const DrawInput& input, const FloatImage& image) {
  OracleError error;
  for (int y = 0; y < input.height; ++y)
    for (int x = 0; x < input.width; ++x) {
      const auto expected = oracle_pixel(input, x, y);
      error.covered += expected[3] > 0 ? 1 : 0;
      for (std::size_t c = 0; c < 4; ++c) {
        const double d =
            std::abs(static_cast<double>(image.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                                         static_cast<std::size_t>(x)) +
                                                    c]) -
                     expected[c]);
        const double e = std::isnan(d) ? 1e9 : d;
        error.mean += e;
        error.above_a_percent += e > 0.01 ? 1 : 0;
        if (e > error.max) error.max = e, error.max_x = x, error.max_y = y;
      }
    }
  const double pixels = static_cast<double>(input.width) * input.height;
  error.mean /= 4 * pixels;
  error.covered /= pixels;
  error.above_a_percent /= 4 * pixels;
  return error;
}

}  // namespace isostrata::testing
