#include "extraction/measure/section.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "data/dataset/analytic.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/measure/linear_layers.h"
#include "extraction/measure/measure_layers.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

double total_area(const Section& section) {
  double sum = 0;
  for (const IntervalSummary& row : section.mesh.summaries) sum += row.area;
  return sum;
}

IntervalMesh tiled_noise(const Grid& grid, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return extract(grid, point_array(random_values(grid.point_count(), 0, 1, random)), tiling({0, 0.3, 0.6, 1}));
}

TEST(Section, OfAllLayersTilesTheSectionOfTheBox) {
  const Task task;
  const Grid grid = uniform_grid({7, 6, 5});  // [0, 6] x [0, 5] x [0, 4]
  struct Case {
    Plane plane;
    double area;
  };
  const Case cases[] = {{{{0, 0, 1.37}, {0, 0, 1}}, 30},
                        {{{0, 0, 2}, {0, 0, -3}}, 30},  // through grid points
                        {{{0, 0, 4}, {0, 0, 1}}, 30},   // the last of them: what lies below it is cut
                        {{{0, 0, 0}, {0, 0, 1}}, 0},    // nothing lies below the first
                        {{{0, 0, 0}, {0, 0, -1}}, 30},
                        {{{3, 2.5, 2}, {1, 0, 0}}, 20},
                        {{{1, 0, 1}, {1, 0, -1}}, 4 * std::sqrt(2.0) * 5},  // x = z, along diagonals of the cells
                        {{{9, 9, 9}, {1, 1, 1}}, 0}};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const IntervalMesh mesh = tiled_noise(grid, seed);
    for (const Case& c : cases) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", normal " + std::to_string(c.plane.normal.x) + " " + std::to_string(c.plane.normal.z));
      const Section section = section_of(mesh, {}, c.plane, task);
      EXPECT_NEAR(total_area(section), c.area, 1e-9);
      EXPECT_EQ(section.unmatched_edges, 0);
      Vec3d turned{};
      for (const BoundaryFacet& facet : section.mesh.facets) {
        const auto& x = section.mesh.positions;
        turned = turned + cross(x[facet.points[1]] - x[facet.points[0]], x[facet.points[2]] - x[facet.points[0]]) * 0.5;
        for (const std::uint32_t p : facet.points) EXPECT_NEAR(dot(normalized(c.plane.normal), x[p] - c.plane.point), 0, 1e-12);
      }
      EXPECT_NEAR(dot(turned, normalized(c.plane.normal)), c.area, 1e-9) << "they face where the normal points, but those of turned tetrahedra";
    }
  }
}

/// The volume of a layer below a plane changes by its section's area as the plane moves.
TEST(Section, IsTheChangeOfTheVolumeBelowThePlane) {
  const Task task;
  const Grid grid = uniform_grid({6, 6, 6});
  const IntervalMesh mesh = tiled_noise(grid, 3);
  const Vec3d normal = normalized(Vec3d{0.3, -0.5, 0.8});
  // By the divergence theorem, of the solid below the plane: its section is what its other facets do not close. The areas of the facets below, along the normal, and the section's sum to 0.
  for (const double offset : {0.37, 1.1, 2.6}) {
    const Section section = section_of(mesh, {}, {normal * offset, normal}, task);
    for (std::uint16_t interval = 0; interval < 3; ++interval) {
      double along = 0;  // of the facets below the plane, each clipped by it
      for (const BoundaryFacet& facet : mesh.facets) {
        if (facet.interval != interval) continue;
        std::vector<Vec3d> polygon;
        for (int k = 0; k < 3; ++k) {
          const Vec3d p = mesh.positions[facet.points[k]], q = mesh.positions[facet.points[(k + 1) % 3]];
          const double dp = dot(normal, p) - offset, dq = dot(normal, q) - offset;
          if (dp < 0) polygon.push_back(p);
          if ((dp < 0) != (dq < 0)) polygon.push_back(lerp(p, q, dp / (dp - dq)));
        }
        for (std::size_t i = 1; i + 1 < polygon.size(); ++i) along += dot(normal, cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0])) / 2;
      }
      EXPECT_NEAR(section.mesh.summaries[interval].area, -along, 1e-9) << "interval " << interval << " at " << offset;
    }
  }
}

TEST(Section, CarriesWhatIsLinearExactlyAndIsMeasuredAsAnArea) {
  const Task task;
  const Layers layers = layers_of_linear({5, 5, 5});
  const Section section = section_of(layers.mesh, layers.carried, {{0, 0, 1.25}, {0, 0, 1}}, task);
  for (std::size_t p = 0; p < section.mesh.positions.size(); ++p) {
    const Vec3d at = section.mesh.positions[p];
    EXPECT_NEAR(section.carried[0].values[p], at.x + 2 * at.y - at.z, 1e-5);
  }
  const LayerMeasure row = measure_layers(section.mesh, section.carried, nullptr, task).front();
  EXPECT_NEAR(row.area.domain, 2 * 4, 1e-12);
  EXPECT_NEAR(row.of[0].mean, 2 + 4 - 1.25, 1e-6);
  EXPECT_NEAR(length(row.centroid - Vec3d{2, 2, 1.25}), 0, 1e-12);
}

TEST(Section, OfAShellIsARing) {
  const Task task;
  const auto dataset = make_analytic("sphere:65", {}, task);
  LayerRequest request;
  request.intervals = {{0.3, 0.5}};
  request.facets = true;
  const Layers layers = extract_layers(request, [&](int, const Task&) { return dataset; }, task);
  const Section section = section_of(layers.mesh, {}, {{0, 0, 0.1}, {1, 2, 3}}, task);
  const double off = 0.3 / std::sqrt(14.0), ring = std::numbers::pi * (0.25 - 0.09);  // both circles shrink alike
  EXPECT_LT(off, 0.3);
  EXPECT_NEAR(section.mesh.summaries[0].area, ring, 2e-3);
  EXPECT_EQ(section.unmatched_edges, 0);
}

}  // namespace
}  // namespace isostrata
