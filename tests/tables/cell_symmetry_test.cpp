#include "tables/cell_symmetry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <set>

#include "tables/interval_complex.h"

namespace isostrata {
namespace {

TEST(CellSymmetry, AreAsManyAsTheCellsHaveAndHalfOfThemMirror) {
  const std::pair<CellType, std::size_t> expected[] = {
      {CellType::tetrahedron, 24}, {CellType::pyramid, 8}, {CellType::wedge, 12}, {CellType::hexahedron, 48}};
  for (const auto& [type, count] : expected) {
    const auto symmetries = cell_symmetries(topology(type));
    EXPECT_EQ(symmetries.size(), count) << topology(type).name;
    EXPECT_EQ(std::count_if(symmetries.begin(), symmetries.end(), [](const CellSymmetry& s) { return s.reverses; }),
              static_cast<std::ptrdiff_t>(count / 2));
  }
}

/// The polytopes of a case as sets of faces, each a cycle from its smallest isovertex.
std::set<std::set<std::vector<IsoVertex>>> polytopes(const IntervalComplex& complex, int case_index,
                                                     const CellSymmetry& symmetry) {
  std::set<std::set<std::vector<IsoVertex>>> out;
  for (std::size_t at = complex.first[case_index]; at < complex.first[case_index + 1];) {
    std::set<std::vector<IsoVertex>> faces;
    for (int count = complex.code[at++]; count > 0; --count) {
      std::vector<IsoVertex> cycle(complex.code[at]);
      for (std::size_t i = 0; i < cycle.size(); ++i) cycle[i] = symmetry.isovertex[complex.code[at + 1 + i]];
      at += 1 + cycle.size();
      if (symmetry.reverses) std::reverse(cycle.begin(), cycle.end());
      std::rotate(cycle.begin(), std::min_element(cycle.begin(), cycle.end()), cycle.end());
      faces.insert(cycle);
    }
    out.insert(faces);
  }
  return out;
}

TEST(CellSymmetry, MapsPolytopesToPolytopesWhateverCaseTheyWereMadeFrom) {
  for (const CellType type : kCellTypes) {
    const IntervalComplex& complex = interval_complex(type);
    const auto symmetries = cell_symmetries(topology(type));
    const auto identity = std::find_if(symmetries.begin(), symmetries.end(),
                                       [](const CellSymmetry& s) { return std::is_sorted(s.vertex.begin(), s.vertex.end()); });
    ASSERT_NE(identity, symmetries.end());
    const int cases = case_count(topology(type).vertex_count);
    for (int i = 0; i<cases; i += cases> 1000 ? 17 : 1)
      for (const CellSymmetry& symmetry : symmetries)
        ASSERT_EQ(polytopes(complex, i, symmetry), polytopes(complex, symmetry.map_case(i), *identity))
            << topology(type).name << ", case " << i;
  }
}

}  // namespace
}  // namespace isostrata
