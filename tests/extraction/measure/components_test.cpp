#include "extraction/measure/components.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <random>

#include "extraction/small_grids.h"

namespace isostrata {
namespace {

/// Pieces by shared facets, which is another way: from tetrahedron to tetrahedron.
std::vector<int> pieces_by_facets(const IntervalMesh& mesh) {
  std::map<std::array<std::uint32_t, 3>, std::vector<std::uint32_t>> of_facet;
  const auto facets = [&](std::uint32_t t, const auto& what) {
    for (int left_out = 0; left_out < 4; ++left_out) {
      std::array<std::uint32_t, 3> facet{};
      for (int k = 0, n = 0; k < 4; ++k)
        if (k != left_out) facet[n++] = mesh.tetrahedra[t][k];
      std::sort(facet.begin(), facet.end());
      what(facet);
    }
  };
  for (std::uint32_t t = 0; t < mesh.tetrahedra.size(); ++t) facets(t, [&](const auto& facet) { of_facet[facet].push_back(t); });
  std::vector<int> piece(mesh.tetrahedra.size(), -1);
  int pieces = 0;
  for (std::uint32_t start = 0; start < mesh.tetrahedra.size(); ++start) {
    if (piece[start] >= 0) continue;
    std::queue<std::uint32_t> open({start});
    piece[start] = pieces;
    for (; !open.empty(); open.pop())
      facets(open.front(), [&](const auto& facet) {
        for (const std::uint32_t other : of_facet[facet])
          if (piece[other] < 0 && mesh.tetrahedron_interval[other] == mesh.tetrahedron_interval[start]) piece[other] = pieces, open.push(other);
      });
    ++pieces;
  }
  return piece;
}

IntervalMesh of_noise(const Grid& grid, std::uint64_t seed, double low, double middle, double high) {
  std::mt19937_64 random(seed);
  const auto array = point_array(random_values(grid.point_count(), 0, 1, random));
  return extract(grid, array, tiling({low, middle, high}));
}

TEST(Components, AreThoseOfSharedFacets) {
  const Task task;
  std::size_t most = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IntervalMesh mesh = of_noise(uniform_grid({7, 6, 8}), seed, 0.02 * static_cast<double>(seed), 0.7, 0.7 + 0.01 * static_cast<double>(seed));
    const Components found = find_components(mesh, task);
    const std::vector<int> other = pieces_by_facets(mesh);
    ASSERT_EQ(found.of.size(), other.size());
    std::map<std::uint32_t, int> same;
    std::map<int, std::uint32_t> back;
    for (std::size_t t = 0; t < other.size(); ++t) {
      EXPECT_EQ(same.emplace(found.of[t], other[t]).first->second, other[t]);
      EXPECT_EQ(back.emplace(other[t], found.of[t]).first->second, found.of[t]);
      EXPECT_EQ(found.interval[found.of[t]], mesh.tetrahedron_interval[t]);
    }
    for (std::size_t piece = 0; piece < found.interval.size(); ++piece) EXPECT_EQ(found.of[found.first_tetrahedron[piece]], piece);
    most = std::max(most, found.interval.size());
  }
  EXPECT_GT(most, 20u) << "noise has many pieces";
}

TEST(Components, OfNothingAreNone) {
  const Task task;
  const Components found = find_components(of_noise(uniform_grid({3, 3, 3}), 1, 5, 6, 7), task);
  EXPECT_TRUE(found.of.empty());
  EXPECT_TRUE(found.interval.empty());
}

TEST(Components, OfTouchingLayersStayApart) {
  const Task task;
  const Grid grid = uniform_grid({5, 5, 5});
  std::vector<double> values;
  for (std::int64_t i = 0; i < grid.point_count(); ++i) values.push_back(grid.point(i).x);
  const Components found = find_components(extract(grid, point_array(values), tiling({0, 1.5, 4})), task);
  EXPECT_EQ(found.interval, (std::vector<std::uint16_t>{0, 1}));
}

TEST(Components, EndWhereTheWorkIsCancelled) {
  Task task;
  task.cancel();
  EXPECT_THROW(find_components(of_noise(uniform_grid({3, 3, 3}), 1, 0, 0.5, 1), task), Error);
}

}  // namespace
}  // namespace isostrata
