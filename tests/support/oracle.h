// The picture as it should be, slowly: in double precision, each pixel's ray through every tetrahedron and facet, in their exact
// order along the ray, the exact integral of each segment. The renderers are measured against it (picture_error.h).
//
// What it decides where DrawInput leaves it open:
//  * Segments follow one another by their middles, so that those that touch are in order however their ends are rounded.
//    Segments that overlap (inverted tetrahedra) have no right order; they too go by their middles.
//  * A surface comes right before the segments that begin at it or right after those that end at it. Of two at the same place the
//    one through which the ray leaves its interval is nearer.
//  * Clip planes cut the ray: what begins at a cut has no surface there.
//  * The depth is that of the nearest segment with any opacity, where it begins, or of the nearest surface with any.
//  * The mean depth of a segment's light is that of one extinction all along it.
//  * Where bodies are shaded, a segment's light is multiplied by what is left of it there (rendering/picture/body_shading.h).
#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "base/parallel.h"
#include "rendering/picture/renderer.h"
#include "support/oracle_bins.h"
#include "support/oracle_light.h"
#include "support/oracle_ray.h"
#include "support/oracle_surface.h"

namespace isostrata::testing {

struct OracleImage {
  int width = 0, height = 0;
  std::vector<std::array<double, 4>> rgba;  // [height][width] premultiplied
  std::vector<double> depth;                // [height][width] along the view direction, infinity where nothing is
  std::vector<double> mean_depth;           // [height][width] premultiplied
};

struct OraclePixel {
  std::array<double, 4> rgba{};
  double depth = std::numeric_limits<double>::infinity(), mean_depth = 0;
};

class Oracle {
 public:
  /// input outlives it.
  explicit Oracle(const DrawInput& input) : input_(input), forward_(oracle_frame(input.camera)[2]) {
    const double unit = input.unit_distance > 0 ? input.unit_distance : default_unit_distance(input.bounds.diagonal());
    for (const IntervalStyle& style : input.styles) {
      optics_.emplace_back(style, unit);
      materials_.push_back(surface_material(style.surface));
    }
    if (input.body_shading > 0)
      for (std::size_t p = 0; p < input.mesh->positions.size(); ++p) shades_.push_back(shade_at(p));
  }

  OraclePixel pixel(int x, int y, const OracleBins::Bin& bin) const {
    const OracleRay ray = oracle_ray(input_, x, y);
    std::map<int, std::vector<Met>> groups;  // by priority
    meet(ray, bin, groups);
    OraclePixel pixel;
    OracleLight sum;
    for (auto& [priority, met] : groups) {
      std::sort(met.begin(), met.end(), [](const Met& a, const Met& b) {
        return std::tie(a.at, a.rank, a.tetrahedron) < std::tie(b.at, b.rank, b.tetrahedron);
      });
      OracleLight group;
      double depths = 0;
      for (const Met& m : met) {
        depths += (1 - group.alpha) * m.light.alpha * std::lerp(depth_at(ray, m.begin), depth_at(ray, m.end), middle_of_light(m.light.alpha));
        group.over(m.light);
        if (m.light.alpha > 0) pixel.depth = std::min(pixel.depth, depth_at(ray, m.begin));
      }
      pixel.mean_depth = depths + (1 - group.alpha) * pixel.mean_depth;
      group.over(sum);  // painted over the lower priorities
      sum = group;
    }
    pixel.rgba = {sum.color[0], sum.color[1], sum.color[2], sum.alpha};
    return pixel;
  }

 private:
  struct Met {
    double at;  // a segment's middle, or where a surface is
    int rank;   // at the same place: surfaces that are left through, segments, surfaces that are entered through
    std::uint32_t tetrahedron;
    double begin, end;  // where it is first seen, and last
    OracleLight light;
  };

  int group_of(std::uint16_t interval) const {
    return input_.mode == RenderMode::prioritized ? input_.styles[interval].priority : 0;
  }
  /// What is left of the light at a point: 1 - s (1 - |cos|), the angle between gradient and view.
  float shade_at(std::size_t point) const {
    const Vec3f& n = (*input_.body_normals)[point];
    const Vec3d normal{n.x, n.y, n.z}, away = input_.mesh->positions[point] - input_.camera.eye;
    if (normal == Vec3d{}) return 1;
    const Vec3d view = input_.camera.orthographic ? forward_ : normalized(away);
    return static_cast<float>(1 - input_.body_shading * (1 - std::abs(dot(normalized(normal), view))));
  }
  OracleLight shaded(OracleLight light, std::uint32_t tetrahedron, const OracleRay& ray) const {
    if (shades_.empty()) return light;
    OracleSegment s{};
    oracle_segment(*input_.mesh, &shades_, tetrahedron, ray, s);
    for (double& channel : light.color) channel *= std::lerp(s.scalar_enter, s.scalar_leave, middle_of_light(light.alpha));
    return light;
  }
  /// Where along a segment of this opacity its light comes from on average: the mean of s under exp(-tau s), in [0, 1].
  static double middle_of_light(double alpha) {
    if (!(alpha > 1e-3)) return 0.5 - alpha / 12;
    if (alpha >= 1) return 0;
    return -1 / std::log1p(-alpha) - (1 - alpha) / alpha;
  }
  double depth_at(const OracleRay& ray, double t) const {
    return dot(forward_, ray.origin + ray.direction * t - input_.camera.eye);
  }

  void meet(const OracleRay& ray, const OracleBins::Bin& bin, std::map<int, std::vector<Met>>& groups) const {
    const IntervalMesh& mesh = *input_.mesh;
    for (const std::uint32_t t : bin.tetrahedra) {
      const std::uint16_t interval = mesh.tetrahedron_interval[t];
      OracleSegment s{};
      if (!input_.styles[interval].visible || !oracle_segment(mesh, input_.color_values.get(), t, ray, s)) continue;
      groups[group_of(interval)].push_back(
          {(s.enter + s.leave) / 2, 1, t, s.enter, s.leave,
           shaded(optics_[interval].light(s.leave - s.enter, s.scalar_enter, s.scalar_leave, input_.integral), t, ray)});
    }
    for (const std::uint32_t f : bin.facets) {
      const BoundaryFacet& facet = mesh.facets[f];
      const IntervalStyle& style = input_.styles[facet.interval];
      OracleCrossing crossing{};
      if (!style.visible || !oracle_draws(style.surface, facet.label) || !oracle_crossing(mesh, f, ray, crossing)) continue;
      groups[group_of(facet.interval)].push_back(
          {crossing.at, crossing.entering ? 2 : 0, facet.tetrahedron, crossing.at, crossing.at,
           oracle_surface(input_, optics_[facet.interval], materials_[facet.interval], ray, crossing)});
    }
  }

  const DrawInput& input_;
  Vec3d forward_;
  std::vector<OracleOptics> optics_;        // [intervals]
  std::vector<SurfaceMaterial> materials_;  // [intervals]
  std::vector<float> shades_;               // [np] where bodies are shaded
};

/// The whole picture. Parallel over rows.
inline OracleImage oracle_image(const DrawInput& input) {
  OracleImage image{input.width, input.height, {}, {}, {}};
  const auto width = static_cast<std::size_t>(input.width), pixels = width * static_cast<std::size_t>(input.height);
  image.rgba.resize(pixels);
  image.depth.resize(pixels);
  image.mean_depth.resize(pixels);
  const Oracle oracle(input);
  const OracleBins bins(input);
  parallel_for(input.height, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y)
      for (int x = 0; x < input.width; ++x) {
        const OraclePixel pixel = oracle.pixel(x, static_cast<int>(y), bins.of_pixel(x, static_cast<int>(y)));
        const std::size_t at = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
        image.rgba[at] = pixel.rgba;
        image.depth[at] = pixel.depth;
        image.mean_depth[at] = pixel.mean_depth;
      }
  });
  return image;
}

/// Premultiplied colour and alpha of one pixel, by brute force: every tetrahedron and every facet is tried.
inline std::array<double, 4> oracle_pixel(const DrawInput& input, int x, int y) {
  return Oracle(input).pixel(x, y, whole_mesh(*input.mesh)).rgba;
}

struct OracleError {
  double max = 0, mean = 0;
  int max_x = 0, max_y = 0;
  double covered = 0;          // the share of pixels with some opacity
  double above_a_percent = 0;  // the share of channel values that differ by more than 0.01
};

/// The picture's error, over all pixels and channels. NaN counts as 1e9.
inline OracleError compare_images(const OracleImage& expected, const FloatImage& image) {
  OracleError error;
  for (std::size_t i = 0; i < expected.rgba.size(); ++i) {
    error.covered += expected.rgba[i][3] > 0 ? 1 : 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const double d = std::abs(double{image.rgba[4 * i + c]} - expected.rgba[i][c]), e = std::isnan(d) ? 1e9 : d;
      error.mean += e;
      error.above_a_percent += e > 0.01 ? 1 : 0;
      if (!(e > error.max)) continue;
      error.max = e;
      error.max_x = static_cast<int>(i) % expected.width;
      error.max_y = static_cast<int>(i) / expected.width;
    }
  }
  const auto pixels = static_cast<double>(expected.rgba.size());
  error.mean /= 4 * pixels;
  error.covered /= pixels;
  error.above_a_percent /= 4 * pixels;
  return error;
}

inline OracleError compare_with_oracle(const DrawInput& input, const FloatImage& image) {
  return compare_images(oracle_image(input), image);
}

}  // namespace isostrata::testing
