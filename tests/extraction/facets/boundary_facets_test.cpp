#include "extraction/facets/boundary_facets.h"

#include <map>
#include <tuple>

#include "data/dataset/analytic.h"
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
      if (facet.label == FacetLabel::lower) {
        ASSERT_EQ(mesh.values[p], interval.lower);
      }
      if (facet.label == FacetLabel::upper) {
        ASSERT_EQ(mesh.values[p], interval.upper);
      }
      for (int side = 0; side < 6; ++side) on_side[side] &= std::abs(mesh.positions[p][side / 2] - (side % 2 ? 1 : -1)) < 1e-12;
    }
    if (facet.label == FacetLabel::domain) {
      ASSERT_TRUE(std::any_of(on_side, on_side + 6, [](bool on) { return on; }));
    }
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

/// By the definition: every facet against all others with the same points and interval.
std::int64_t unmatched_slowly(const IntervalMesh& mesh) {
  struct Uses {
    int inside = 0, boundary = 0, odd = 0;
  };
  std::map<std::pair<std::array<std::uint32_t, 3>, int>, Uses> uses;
  constexpr int kFacets[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (int f = 0; f < 4; ++f) {
      std::array<std::uint32_t, 3> p;
      for (int k = 0; k < 3; ++k) p[k] = mesh.tetrahedra[t][kFacets[f][k]];
      const bool boundary = std::any_of(mesh.facets.begin(), mesh.facets.end(), [&](const BoundaryFacet& facet) {
        auto a = facet.points, b = p;
        std::sort(a.begin(), a.end());
        std::sort(b.begin(), b.end());
        return facet.tetrahedron == t && a == b;
      });
      const bool odd = (p[0] > p[1]) ^ (p[1] > p[2]) ^ (p[0] > p[2]);
      std::sort(p.begin(), p.end());
      Uses& at = uses[{p, mesh.tetrahedron_interval[t]}];
      at.inside += !boundary;
      at.boundary += boundary;
      at.odd += odd && !boundary;
    }
  std::int64_t count = 0;
  for (const auto& [key, at] : uses)
    if (at.inside > 0 && !(at.inside == 2 && at.odd == 1 && at.boundary == 0)) count += at.inside + at.boundary;
  return count;
}

TEST(CountUnmatchedFacets, AgreesWithItsDefinitionOnTetrahedraThatMeetByChance) {
  std::int64_t found = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const int points = 5 + static_cast<int>(seed % 4);
    IntervalMesh mesh;
    mesh.positions.resize(static_cast<std::size_t>(points));
    for (int t = 0; t < 30; ++t) {
      const auto numbers = random_numbers(points, random);
      mesh.tetrahedra.push_back({static_cast<std::uint32_t>(numbers[0]), static_cast<std::uint32_t>(numbers[1]),
                                 static_cast<std::uint32_t>(numbers[2]), static_cast<std::uint32_t>(numbers[3])});
      mesh.tetrahedron_interval.push_back(static_cast<std::uint16_t>(random() % (1 + seed % 3)));
      if (random() % 3 == 0)
        mesh.facets.push_back({{mesh.tetrahedra.back()[1], mesh.tetrahedra.back()[3], mesh.tetrahedra.back()[2]},
                               static_cast<std::uint32_t>(t),
                               mesh.tetrahedron_interval.back(),
                               FacetLabel::domain});
    }
    const std::int64_t expected = unmatched_slowly(mesh);
    EXPECT_EQ(unmatched(mesh), expected);
    found += 120 - expected;
  }
  EXPECT_GT(found, 0) << "some facets meet";
}

TEST(CountUnmatchedFacets, AgreesWithItsDefinitionOnBrokenMeshes) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    IntervalMesh mesh = extract_analytic("mixed:6", tiling({0.2, 0.5, 0.6}));
    for (int i = 0; i < 20; ++i) {
      auto& t = mesh.tetrahedra[random() % mesh.tetrahedra.size()];
      if (i % 2)
        std::swap(t[0], t[1]);
      else
        t[random() % 4] = static_cast<std::uint32_t>(random() % mesh.positions.size());
    }
    mesh.facets.clear();
    EXPECT_EQ(unmatched(mesh), unmatched_slowly(mesh));
  }
}

TEST(CountUnmatchedFacets, CountsWhatLiesOverItselfManyTimes) {
  IntervalMesh mesh;
  mesh.positions.resize(4);
  for (int i = 0; i < 1000; ++i) {
    mesh.tetrahedra.push_back({0, 1, 2, 3});
    mesh.tetrahedron_interval.push_back(0);
  }
  EXPECT_EQ(unmatched(mesh), 4000);
}

}  // namespace
}  // namespace isostrata
