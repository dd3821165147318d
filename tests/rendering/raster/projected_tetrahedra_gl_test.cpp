// Laws of light, drawn by llvmpipe.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/oracle.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

DrawInput slab(double unit_distance, double opacity) {
  IntervalMesh mesh;
  add_box(mesh, {-1, -1, -0.25}, {1, 1, 0.25}, 0, 0);
  DrawInput input = input_of(std::move(mesh), opacity);
  input.unit_distance = unit_distance;
  return input;
}

TEST(ProjectedTetrahedra, ASlabLetsThroughTheExponentialOfItsThicknessStraightOn) {
  for (const double unit : {0.02, 0.1, 1.0, 30.0}) {
    DrawInput input = slab(unit, 0.6);
    input.camera = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 30};
    const FloatImage image = draw_floats(input);
    double worst = 0;
    for (int y = 0; y < input.height; ++y)
      for (int x = 0; x < input.width; ++x) {
        const Vec3d direction = oracle_direction(input, x, y);
        const Vec3d front = direction * (2.75 / -direction.z), back = direction * (3.25 / -direction.z);
        if (std::max(std::abs(back.x), std::abs(back.y)) > 0.95) continue;  // leaves through a side
        const double expected = std::exp(-extinction(0.6, unit) * length(back - front));
        worst = std::max(worst, std::abs(1 - static_cast<double>(pixel(image, x, y)[3]) - expected));
      }
    RecordProperty("worst_" + std::to_string(unit), std::to_string(worst));
    EXPECT_LT(worst, for_triangles(2e-6, 10)) << "unit distance " << unit;
  }
}

TEST(ProjectedTetrahedra, ASlabLetsThroughTheExponentialOfItsThicknessTilted) {
  for (const double unit : {0.05, 0.5, 5.0})
    for (const Vec3d eye : {Vec3d{2, 1, 2}, Vec3d{-3, 0.3, 0.6}, Vec3d{0.2, -2.5, -2}, Vec3d{1.1, 0.4, 0.3}}) {
      DrawInput input = slab(unit, 0.5);
      input.camera.eye = eye;
      input.camera.at = {0.1, -0.05, 0};
      const FloatImage image = draw_floats(input);
      const OracleError error = compare_with_oracle(input, image);
      EXPECT_GT(error.covered, 0.05);
      // The worst pixels have their middle within 1/256 of the silhouette, where the rasterizer's grid decides.
      EXPECT_LT(error.mean, for_triangles(2e-6, 20)) << "unit distance " << unit << ", eye " << eye.x << "," << eye.y << "," << eye.z << " max "
                                  << error.max << " at " << error.max_x << "," << error.max_y;
      EXPECT_LT(error.max, for_triangles(2e-3, 10)) << "unit distance " << unit << ", eye " << eye.x << "," << eye.y << "," << eye.z << " at "
                                 << error.max_x << "," << error.max_y;
    }
}

}  // namespace
}  // namespace isostrata
