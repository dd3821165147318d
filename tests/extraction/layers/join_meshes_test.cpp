#include "extraction/layers/join_meshes.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {
namespace {

IntervalMesh torus_part(double lower, double upper) {
  const auto dataset = make_analytic("torus:10", {}, Task{});
  const Interval intervals[] = {{lower, upper}, {upper, upper + 0.1}};
  ExtractOptions options;
  options.facets = true;
  return extract_intervals(dataset->grid, dataset->arrays[0], intervals, options, Task{});
}

TEST(JoinMeshes, EachPartIsThereAsItWas) {
  const IntervalMesh a = torus_part(0.1, 0.2), b = torus_part(0.3, 0.5);
  const IntervalMesh* const parts[] = {&a, &b};
  const IntervalMesh joined = join_meshes(parts, 1 << 30);
  ASSERT_EQ(joined.tetrahedra.size(), a.tetrahedra.size() + b.tetrahedra.size());
  ASSERT_EQ(joined.facets.size(), a.facets.size() + b.facets.size());
  ASSERT_EQ(joined.summaries.size(), 4u);
  EXPECT_EQ(joined.summaries[2].volume, b.summaries[0].volume);
  for (std::size_t t = 0; t < b.tetrahedra.size(); ++t) {
    const std::size_t to = a.tetrahedra.size() + t;
    ASSERT_EQ(joined.tetrahedron_interval[to], b.tetrahedron_interval[t] + 2);
    for (std::size_t v = 0; v < 4; ++v) ASSERT_EQ(joined.positions[joined.tetrahedra[to][v]], b.positions[b.tetrahedra[t][v]]);
  }
  for (std::size_t f = 0; f < b.facets.size(); ++f) {
    const BoundaryFacet& facet = joined.facets[a.facets.size() + f];
    ASSERT_EQ(joined.tetrahedron_interval[facet.tetrahedron], facet.interval);
    for (const std::uint32_t p : facet.points) {  // a facet's points are among its tetrahedron's
      const auto& points = joined.tetrahedra[facet.tetrahedron];
      ASSERT_NE(std::find(points.begin(), points.end(), p), points.end());
    }
  }
  for (std::size_t r = 0; r + 1 < joined.cell_runs.size(); ++r)
    ASSERT_LT(joined.cell_runs[r].first_tetrahedron, joined.cell_runs[r + 1].first_tetrahedron);
}

TEST(JoinMeshes, NothingIsTakenAboveTheLimit) {
  const IntervalMesh a = torus_part(0.1, 0.2);
  const IntervalMesh* const parts[] = {&a, &a};
  EXPECT_THROW(join_meshes(parts, mesh_bytes(a)), Error);
}

TEST(JoinMeshes, NoneMakeAnEmptyOne) { EXPECT_TRUE(join_meshes({}, 0).tetrahedra.empty()); }

}  // namespace
}  // namespace isostrata
