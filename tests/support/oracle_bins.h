// Which tetrahedra and facets a pixel's ray may meet: lists by square of the screen. Only saves time; the oracle without it is
// the same.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/oracle_ray.h"

namespace isostrata::testing {

class OracleBins {
 public:
  struct Bin {
    std::vector<std::uint32_t> tetrahedra, facets;
  };

  explicit OracleBins(const DrawInput& input)
      : columns_((input.width + kSide - 1) / kSide), rows_((input.height + kSide - 1) / kSide) {
    bins_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    const IntervalMesh& mesh = *input.mesh;
    const auto [right, up, forward] = oracle_frame(input.camera);
    const double half = half_height(input.camera), distance = length(input.camera.eye - input.camera.at);
    std::vector<std::array<double, 2>> pixel(mesh.positions.size());  // NaN where the point is too near to have a picture
    std::vector<std::uint8_t> behind(mesh.positions.size(), 0);       // the eye
    for (std::size_t i = 0; i < pixel.size(); ++i) {
      const Vec3d p = mesh.positions[i] - input.camera.eye;
      const double depth = dot(forward, p);
      const double scale = 0.5 * input.height / half * (input.camera.orthographic ? 1.0 : distance / depth);
      pixel[i] = {0.5 * input.width + dot(right, p) * scale, 0.5 * input.height - dot(up, p) * scale};
      if (!input.camera.orthographic && !(depth > 1e-6 * distance)) pixel[i][0] = std::nan("");
      behind[i] = !input.camera.orthographic && depth < 0;
    }
    const auto put = [&](const auto& points, std::uint32_t id, std::vector<std::uint32_t> Bin::*list) {
      double lower[2] = {1e30, 1e30}, upper[2] = {-1e30, -1e30};
      bool everywhere = false, unseen = true;
      for (const std::uint32_t point : points) {
        everywhere = everywhere || std::isnan(pixel[point][0]);
        unseen = unseen && behind[point];
        for (std::size_t axis = 0; axis < 2; ++axis) {
          lower[axis] = std::min(lower[axis], pixel[point][axis]);
          upper[axis] = std::max(upper[axis], pixel[point][axis]);
        }
      }
      if (unseen) return;
      const auto square = [&](double at, int count) {  // the one that holds it, clamped
        return static_cast<int>(std::clamp(std::floor(at / kSide), 0.0, count - 1.0));
      };
      const int x0 = everywhere ? 0 : square(lower[0] - 1, columns_),
                x1 = everywhere ? columns_ - 1 : square(upper[0] + 1, columns_);
      const int y0 = everywhere ? 0 : square(lower[1] - 1, rows_), y1 = everywhere ? rows_ - 1 : square(upper[1] + 1, rows_);
      if (!everywhere && (upper[0] < -1 || lower[0] > input.width + 1 || upper[1] < -1 || lower[1] > input.height + 1)) return;
      for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) (bins_[static_cast<std::size_t>(y * columns_ + x)].*list).push_back(id);
    };
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
      if (input.styles[mesh.tetrahedron_interval[t]].visible)
        put(mesh.tetrahedra[t], static_cast<std::uint32_t>(t), &Bin::tetrahedra);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
      if (input.styles[mesh.facets[f].interval].visible) put(mesh.facets[f].points, static_cast<std::uint32_t>(f), &Bin::facets);
  }

  const Bin& of_pixel(int x, int y) const { return bins_[static_cast<std::size_t>(y / kSide * columns_ + x / kSide)]; }

 private:
  static constexpr int kSide = 4;  // pixels
  int columns_, rows_;
  std::vector<Bin> bins_;  // [rows][columns]
};

/// All of the mesh: what the bins are tested against.
inline OracleBins::Bin whole_mesh(const IntervalMesh& mesh) {
  OracleBins::Bin bin;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) bin.tetrahedra.push_back(static_cast<std::uint32_t>(t));
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) bin.facets.push_back(static_cast<std::uint32_t>(f));
  return bin;
}

}  // namespace isostrata::testing
