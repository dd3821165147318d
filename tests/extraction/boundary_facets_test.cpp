#include "extraction/boundary_facets.h"

#include <map>

#include "data/analytic.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

IntervalMesh extract_analytic(std::string_view name, const std::vector<Interval>& intervals) {
  const Task task;
  const auto dataset = make_analytic(name, {}, task);
  return extract(dataset->grid, dataset->arrays[0], intervals);
}

TEST(BoundaryFacets, EncloseTheVolumeOfTheirInterval) {
  for (const char* name : {"torus:20", "mixed:9", "cylinder:12x10x8"}) {
    const bool cylinder = std::string(name).starts_with("cylinder");
    const IntervalMesh mesh = extract_analytic(name, cylinder ? tiling({0.98, 0.995, 1.0}) : tiling({0.2, 0.5, 0.6}));
    std::vector<double> enclosed(mesh.summaries.size());
    for (const BoundaryFacet& facet : mesh.facets) {
      const auto& x = mesh.positions;
      enclosed[facet.interval] += dot(x[facet.points[0]], cross(x[facet.points[1]], x[facet.points[2]])) / 6;
    }
    for (std::size_t i = 0; i < enclosed.size(); ++i) {
      ASSERT_GT(mesh.summaries[i].signed_volume, 0);
      EXPECT_NEAR(enclosed[i], mesh.summaries[i].signed_volume, 1e-10 * mesh.summaries[i].volume) << name << ", interval " << i;
    }
  }
}

TEST(BoundaryFacets, CloseUp) {
  const IntervalMesh mesh = extract_analytic("mixed:9", tiling({0.2, 0.5, 0.6}));
  std::map<std::tuple<std::uint16_t, std::uint32_t, std::uint32_t>, int> balance;
  for (const BoundaryFacet& facet : mesh.facets)
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = facet.points[i], b = facet.points[(i + 1) % 3];
      balance[{facet.interval, std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  ASSERT_FALSE(balance.empty());
  for (const auto& [edge, sum] : balance) ASSERT_EQ(sum, 0) << "each edge is walked as often one way as the other";
}

TEST(BoundaryFacets, LieOnTheIsosurfaceOrTheDomainThatTheyName) {
  const IntervalMesh mesh = extract_analytic("torus:24", {{0.2, 0.7}, {0.7, 1.0}});
  ASSERT_GT(count_label(mesh, FacetLabel::lower), 0);
  ASSERT_GT(count_label(mesh, FacetLabel::upper), 0);
  ASSERT_GT(count_label(mesh, FacetLabel::domain), 0);
  for (const BoundaryFacet& facet : mesh.facets) {
    const Interval interval = mesh.summaries[facet.interval].interval;
    bool on_side[6] = {true, true, true, true, true, true};
    for (const std::uint32_t p : facet.points) {
      if (facet.label == FacetLabel::lower) { ASSERT_EQ(mesh.values[p], interval.lower); }
      if (facet.label == FacetLabel::upper) { ASSERT_EQ(mesh.values[p], interval.upper); }
      for (int side = 0; side < 6; ++side) on_side[side] &= std::abs(mesh.positions[p][side / 2] - (side % 2 ? 1 : -1)) < 1e-12;
    }
    if (facet.label == FacetLabel::domain) { ASSERT_TRUE(std::any_of(on_side, on_side + 6, [](bool on) { return on; })); }
  }
}

TEST(BoundaryFacets, OfAWholeBoxAreItsSurface) {
  const IntervalMesh mesh = extract(uniform_grid({4, 3, 5}), point_array(std::vector<double>(60, 0.5)), {{0, 1}});
  EXPECT_EQ(count_label(mesh, FacetLabel::domain), 2 * 2 * (3 * 2 + 2 * 4 + 3 * 4));
  EXPECT_EQ(static_cast<std::int64_t>(mesh.facets.size()), count_label(mesh, FacetLabel::domain));
}

TEST(CountUnmatchedFacets, FindsWhatIsBroken) {
  IntervalMesh mesh = extract(uniform_grid({4, 4, 4}), point_array(std::vector<double>(64, 0.5)), {{0, 1}});
  ASSERT_EQ(unmatched(mesh), 0);
  IntervalMesh cracked = mesh;  // a point of one tetrahedron torn off
  cracked.positions.push_back(cracked.positions[cracked.tetrahedra[70][0]]);
  cracked.tetrahedra[70][0] = static_cast<std::uint32_t>(cracked.positions.size() - 1);
  EXPECT_GT(unmatched(cracked), 0);
  IntervalMesh twice = mesh;  // a tetrahedron that lies over another
  twice.tetrahedra.push_back(twice.tetrahedra[70]);
  twice.tetrahedron_interval.push_back(0);
  EXPECT_GT(unmatched(twice), 0);
  IntervalMesh unlisted = mesh;  // a boundary facet that nobody listed
  unlisted.facets.pop_back();
  EXPECT_EQ(unmatched(unlisted), 1);
  IntervalMesh turned = mesh;  // orientation that disagrees with the neighbours'
  std::swap(turned.tetrahedra[70][0], turned.tetrahedra[70][1]);
  EXPECT_GT(unmatched(turned), 0);
}

TEST(CountUnmatchedFacets, SeesAFaceSharedByThreeCells) {
  UnstructuredParts parts;
  parts.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 0, -2}};
  parts.add(CellType::tetrahedron, {0, 1, 2, 3});
  parts.add(CellType::tetrahedron, {0, 2, 1, 4});
  EXPECT_EQ(unmatched(extract(unstructured_grid(parts), point_array(std::vector<double>(6, 0.5)), {{0, 1}})), 0);
  parts.add(CellType::tetrahedron, {0, 2, 1, 5});
  EXPECT_EQ(unmatched(extract(unstructured_grid(parts), point_array(std::vector<double>(6, 0.5)), {{0, 1}})), 3);
}

TEST(CountUnmatchedFacets, TakesATriangleOnAQuadrilateralForTwoBoundaries) {
  UnstructuredParts parts;
  parts.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {0.7, 0.3, 2}};
  parts.add(CellType::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7});
  parts.add(CellType::tetrahedron, {4, 5, 6, 8});  // on half of the face 4 5 6 7: no face is shared
  const IntervalMesh mesh = extract(unstructured_grid(parts), point_array(std::vector<double>(9, 0.5)), {{0, 1}});
  EXPECT_EQ(unmatched(mesh), 0);
  EXPECT_EQ(count_label(mesh, FacetLabel::domain), 12 + 4);
}

}  // namespace
}  // namespace isostrata
