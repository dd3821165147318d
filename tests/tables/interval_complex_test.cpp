#include "tables/interval_complex.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "tables/interval_table.h"
#include "tables/lattice_geometry.h"

namespace isostrata {
namespace {

using Tetrahedra = std::vector<std::array<IsoVertex, 4>>;

Tetrahedra pulled(CellType type, int case_index, const std::vector<std::int64_t>& ids) {
  std::array<std::uint8_t, kMaxIsoVertices> keys;
  order_isovertices(topology(type), ids, keys);
  Tetrahedra out(kMaxCaseTetrahedra);
  out.resize(pull(interval_complex(type), case_index, keys, out.data()));
  return out;
}

std::vector<std::int64_t> shuffled_ids(int n, std::mt19937_64& random) {
  std::vector<std::int64_t> ids(n);
  std::iota(ids.begin(), ids.end(), 100);
  std::shuffle(ids.begin(), ids.end(), random);
  return ids;
}

TEST(IntervalComplex, TilesTheCellForEveryCaseOfEveryCellInAnyOrder) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (const CellType type : kCellTypes) {
    ValuedCell cell{lattice_cell(type), {}, {}};
    const int n = cell.lattice.vertex_count();
    for (int i = 0; i < case_count(n); ++i) {
      const double volume = place_randomly(cell, random);
      const auto ids = shuffled_ids(n, random);
      cell.values.clear();
      for (int v = 0, rest = i; v < n; ++v, rest /= 3) cell.values.push_back(rest % 3 + uniform(random));
      double sum = 0;
      std::vector<double> ends{0, uniform(random), 1, 2, 2 + uniform(random), 3};  // the case itself, its neighbours cut at random
      for (std::size_t k = 0; k + 1 < ends.size(); ++k)
        for (const auto& t : pulled(type, cell.case_index(ends[k], ends[k + 1]), ids))
          sum += cell.signed_volume(t, ends[k], ends[k + 1]);
      ASSERT_NEAR(sum, volume, 1e-12) << cell.lattice.name << ", case " << i << ", seed 12";
    }
  }
}

/// Facets of the tetrahedra that have no partner, as sets with their face masks: what a cell shows to its neighbours.
std::set<std::array<IsoVertex, 3>> free_facets(const Tetrahedra& tetrahedra) {
  std::map<std::array<IsoVertex, 3>, int> count;
  for (const auto& t : tetrahedra)
    for (int skip = 0; skip < 4; ++skip) {
      std::array<IsoVertex, 3> facet;
      for (int i = 0, to = 0; i < 4; ++i)
        if (i != skip) facet[to++] = t[i];
      std::sort(facet.begin(), facet.end());
      ++count[facet];
    }
  std::set<std::array<IsoVertex, 3>> out;
  for (const auto& [facet, uses] : count) {
    EXPECT_LE(uses, 2);
    if (uses == 1) out.insert(facet);
  }
  return out;
}

TEST(IntervalComplex, PulledFacetsMeetInsideTheCellOrLieOnItsBoundary) {
  std::mt19937_64 random(13);
  for (const CellType type : kCellTypes) {
    const int n = topology(type).vertex_count;
    const auto& masks = interval_complex(type).masks;
    for (int i = 0; i < case_count(n); ++i)
      for (const auto& facet : free_facets(pulled(type, i, shuffled_ids(n, random))))
        ASSERT_NE(masks[facet[0]] & masks[facet[1]] & masks[facet[2]], 0) << topology(type).name << ", case " << i << ", seed 13";
  }
}

TEST(IntervalComplex, HasThePlacingTablesIsovertices) {
  for (const CellType type : kCellTypes) {
    const LatticeCell cell = lattice_cell(type);
    const IntervalComplex& complex = interval_complex(type);
    for (int i = 0; i < case_count(cell.vertex_count()); ++i) {
      std::uint32_t used = 0;
      for (const IsoSimplex& s : interval_case(cell, i))
        for (int k = 0; k < 4; ++k) used |= 1u << s.vertex[k];
      ASSERT_EQ(complex.isovertices[i], used) << cell.name << ", case " << i;
    }
  }
}

TEST(IntervalComplex, OrderDependsOnlyOnTheOrderOfGlobalIds) {
  std::mt19937_64 random(14);
  for (const CellType type : kCellTypes) {
    const int n = topology(type).vertex_count;
    auto ids = shuffled_ids(n, random);
    auto stretched = ids;
    for (auto& id : stretched) id = id * id * 1000;
    for (int i = 0; i < case_count(n); i += 7) EXPECT_EQ(pulled(type, i, ids), pulled(type, i, stretched));
  }
}

TEST(HexahedronTable, IsPulledInTheOrderOfAStructuredGrid) {
  const std::vector<std::int64_t> ids{0, 1, 11, 10, 100, 101, 111, 110};
  const HexahedronTable& table = hexahedron_table();
  for (int i = 0; i < case_count(8); ++i) {
    const auto own = table.of(i);
    ASSERT_EQ(pulled(CellType::hexahedron, i, ids), Tetrahedra(own.begin(), own.end())) << "case " << i;
  }
  EXPECT_EQ(table.tetrahedra.size(), 77800u);
}

TEST(HexahedronTable, InvertsFewerTetrahedraThanThePlacingTableOnRandomValues) {
  std::mt19937_64 random(15);
  std::uniform_real_distribution<double> uniform(0, 3);
  ValuedCell cell{lattice_cell(CellType::hexahedron), {}, {}};
  for (const LatticePoint& p : cell.lattice.vertices) cell.points.push_back({double(p[0]), double(p[1]), double(p[2])});
  std::vector<std::vector<IsoSimplex>> placed;
  for (int i = 0; i < case_count(8); ++i) placed.push_back(interval_case(cell.lattice, i));
  std::int64_t inverted_pulled = 0, inverted_placed = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    cell.values.clear();
    for (int v = 0; v < 8; ++v) cell.values.push_back(uniform(random));
    const int i = cell.case_index(1, 2);
    for (const auto& t : hexahedron_table().of(i)) inverted_pulled += cell.signed_volume(t, 1, 2) < -1e-13;
    for (const IsoSimplex& s : placed[i]) inverted_placed += cell.signed_volume(s.vertex, 1, 2) < -1e-13;
  }
  RecordProperty("inverted_pulled", static_cast<int>(inverted_pulled));
  RecordProperty("inverted_placed", static_cast<int>(inverted_placed));
  EXPECT_LT(inverted_pulled, inverted_placed) << "seed 15";
}

}  // namespace
}  // namespace isostrata
