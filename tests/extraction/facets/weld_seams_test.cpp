// Grids that meet themselves: nothing is a boundary where an O-grid closes.
#include "extraction/facets/weld_seams.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "data/dataset/analytic.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/laws/check_laws.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

/// A grid of explicit points around the z axis, whose values the test may change.
struct Ring {
  std::vector<Vec3d> points;
  std::vector<double> values;
  std::vector<std::uint8_t> hidden;
  std::array<std::int64_t, 3> dims;  // around, outward, up; or any other order of the three

  /// `order`: which axis of the grid goes around, outward, up. closed_tube: outward closes as well, so that it is a torus.
  explicit Ring(std::array<int, 3> order = {0, 1, 2}, bool torus = false) {
    const std::array<std::int64_t, 3> sizes{9, torus ? 6 : 4, torus ? 3 : 5};
    for (std::size_t a = 0; a < 3; ++a) dims[static_cast<std::size_t>(order[a])] = sizes[a];
    std::array<std::int64_t, 3> at;
    for (at[2] = 0; at[2] < dims[2]; ++at[2])
      for (at[1] = 0; at[1] < dims[1]; ++at[1])
        for (at[0] = 0; at[0] < dims[0]; ++at[0]) {
          const auto of = [&](std::size_t a) { return at[static_cast<std::size_t>(order[a])]; };
          const double around = 2 * M_PI * static_cast<double>(of(0) % (sizes[0] - 1)) / static_cast<double>(sizes[0] - 1);
          const double tube = 2 * M_PI * static_cast<double>(of(1) % (sizes[1] - 1)) / static_cast<double>(sizes[1] - 1);
          const double thick = 0.2 + 0.2 * static_cast<double>(of(2));
          const double r = torus ? 2 + thick * std::cos(tube) : 1 + static_cast<double>(of(1));
          const double z = torus ? thick * std::sin(tube) : static_cast<double>(of(2));
          points.push_back({r * std::cos(around), r * std::sin(around), z});
          values.push_back(std::sin(around + 0.3) + 0.2 * r + 0.1 * z);
        }
    hidden.assign(static_cast<std::size_t>((dims[0] - 1) * (dims[1] - 1) * (dims[2] - 1)), 0);
  }
  Grid grid() const {
    Grid grid;
    grid.shape = CurvilinearGrid{dims, std::span<const Vec3d>(points)};
    if (std::count(hidden.begin(), hidden.end(), 1)) grid.hidden_cells = hidden;
    return grid;
  }
  PointArray array() const {
    PointArray array;
    array.name = "f";
    array.type = ScalarType::float64;
    array.values = std::span<const double>(values);
    measure_range(array);
    return array;
  }
};

std::int64_t broken_laws(const Grid& grid, const IntervalMesh& mesh) {
  std::int64_t count = 0;
  for (const BrokenLaw& law : check_laws(grid, mesh, {}, Task())) {
    ADD_FAILURE() << law.law << ": " << law.first;
    ++count;
  }
  return count;
}

const std::vector<Interval> kAll{{-100, 100}};

TEST(WeldSeams, AnOGridEndsWhereItEndsAndNotWhereItCloses) {
  for (const std::array<int, 3>& order : {std::array{0, 1, 2}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}}) {
    const Ring ring(order);
    const IntervalMesh mesh = extract(ring.grid(), ring.array(), kAll);
    // 8 around, 3 outward, 4 up: the tube's inside and outside, its bottom and its lid, of two triangles for each face.
    EXPECT_EQ(count_label(mesh, FacetLabel::domain), 2 * (2 * 8 * 4 + 2 * 8 * 3));
    EXPECT_EQ(count_unmatched_facets(mesh, Task()), 0);
    EXPECT_EQ(broken_laws(ring.grid(), mesh), 0);
  }
}

TEST(WeldSeams, ATorusOfTwoSeamsEndsAtItsInnerAndOuterSheetAlone) {
  const Ring ring({0, 1, 2}, true);
  const IntervalMesh mesh = extract(ring.grid(), ring.array(), kAll);
  EXPECT_EQ(count_label(mesh, FacetLabel::domain), 2 * 2 * 8 * 5);
  EXPECT_EQ(broken_laws(ring.grid(), mesh), 0);
}

TEST(WeldSeams, IntervalsAcrossTheSeamAreOneMesh) {
  for (const bool torus : {false, true}) {
    const Ring ring({0, 1, 2}, torus);
    const auto intervals = tiling({-0.5, 0.1, 0.4, 0.45, 1.2});
    const IntervalMesh mesh = extract(ring.grid(), ring.array(), intervals);
    EXPECT_EQ(broken_laws(ring.grid(), mesh), 0);
    ExtractOptions options;
    options.facets = true;
    const IntervalMesh general = extract_in_general(ring.grid(), ring.array(), intervals, options, Task());
    EXPECT_EQ(count_label(general, FacetLabel::domain), count_label(mesh, FacetLabel::domain));
    options.strict = true;
    const IntervalMesh strict = extract_intervals(ring.grid(), ring.array(), intervals, options, Task());
    EXPECT_EQ(count_unmatched_facets(strict, Task()), 0);
    EXPECT_EQ(count_label(strict, FacetLabel::domain), count_label(mesh, FacetLabel::domain));
    // Turned by one cell, the same solid has its seam elsewhere, and nobody can tell.
    Ring turned = ring;
    const std::int64_t n = ring.dims[0];
    for (std::size_t p = 0; p < ring.points.size(); ++p) {
      const auto i = static_cast<std::int64_t>(p) % n;
      const auto from = p - static_cast<std::size_t>(i) + static_cast<std::size_t>((i % (n - 1) + 1) % (n - 1));
      turned.points[p] = ring.points[from];
      turned.values[p] = ring.values[from];
    }
    const IntervalMesh other = extract(turned.grid(), turned.array(), intervals);
    for (const FacetLabel label : {FacetLabel::lower, FacetLabel::upper, FacetLabel::domain})
      EXPECT_EQ(count_label(other, label), count_label(mesh, label));
  }
}

TEST(WeldSeams, WhereTheFieldJumpsOrACellIsMissingTheSeamIsABoundary) {
  Ring jump;
  jump.values[8] += 1e-9;  // of the last sheet
  const IntervalMesh torn = extract(jump.grid(), jump.array(), kAll);
  EXPECT_EQ(count_label(torn, FacetLabel::domain), 2 * (2 * 8 * 4 + 2 * 8 * 3 + 2 * 3 * 4));

  Ring moved;
  moved.points[8].x = std::nextafter(moved.points[8].x, 9.0);
  EXPECT_EQ(count_label(extract(moved.grid(), moved.array(), kAll), FacetLabel::domain), count_label(torn, FacetLabel::domain));

  Ring hole;
  hole.hidden[0] = 1;  // beside the seam, at the bottom and inside: four of its faces become boundary, two are no more
  const IntervalMesh open = extract(hole.grid(), hole.array(), kAll);
  EXPECT_EQ(count_label(open, FacetLabel::domain), 2 * (2 * 8 * 4 + 2 * 8 * 3 + 4 - 2));
  EXPECT_EQ(broken_laws(hole.grid(), open), 0);
}

TEST(WeldSeams, TheBuiltInCylinderHasNoWall) {
  const auto data = make_analytic("cylinder:24x12x8", {}, Task());
  const IntervalMesh mesh = extract(data->grid, data->arrays[0], kAll);
  EXPECT_EQ(count_label(mesh, FacetLabel::domain), 2 * (2 * 23 * 7 + 2 * 23 * 11));
  EXPECT_EQ(broken_laws(data->grid, mesh), 0);
}

TEST(WeldSeams, OrdinaryGridsHaveNone) {
  for (const char* name : {"torus:9", "tets:5", "mixed:9"}) {
    const auto data = make_analytic(name, {}, Task());
    EXPECT_EQ(find_seams(data->grid, data->arrays[0]), (std::array<bool, 3>{}));
  }
}

}  // namespace
}  // namespace isostrata
