// What a mesh says whatever its points and cells are numbered like, for comparing two ways of making it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <vector>

#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// A point by where it comes from: grid edge and value (0 for grid points).
using PointName = std::tuple<std::int64_t, std::int64_t, double>;

struct MeshContent {
  std::vector<PointName> points;
  std::vector<std::tuple<std::int64_t, int, std::array<PointName, 4>>> tetrahedra;   // cell, interval, points
  std::vector<std::tuple<std::int64_t, int, int, std::array<PointName, 3>>> facets;  // cell, interval, label, points
  std::vector<std::tuple<std::int64_t, std::int64_t, std::int64_t>> counts;          // of the summaries
  std::map<PointName, std::tuple<double, double, double>> positions;

  bool operator==(const MeshContent&) const = default;
};

/// Sorts the points by even permutations: what stays is the set and the orientation.
template <std::size_t kSize>
std::array<PointName, kSize> in_even_order(std::array<PointName, kSize> p) {
  bool odd = false;
  for (std::size_t i = 0; i < kSize; ++i)
    for (std::size_t j = i + 1; j < kSize; ++j)
      if (p[j] < p[i]) {
        std::swap(p[i], p[j]);
        odd = !odd;
      }
  if (odd) std::swap(p[0], p[1]);
  return p;
}

/// Precondition: extracted with values.
inline MeshContent content_of(const IntervalMesh& mesh) {
  MeshContent out;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto a = mesh.origins[i].a(), b = mesh.origins[i].b();
    out.points.emplace_back(a, b, a == b ? 0 : mesh.values[i]);
    out.positions[out.points.back()] = {mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z};
  }
  std::vector<std::int64_t> cell_of(mesh.tetrahedra.size());
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    const std::size_t end = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : mesh.tetrahedra.size();
    for (std::size_t t = mesh.cell_runs[r].first_tetrahedron; t < end; ++t) cell_of[t] = mesh.cell_runs[r].cell;
  }
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    std::array<PointName, 4> names;
    for (int k = 0; k < 4; ++k) names[k] = out.points[mesh.tetrahedra[t][k]];
    out.tetrahedra.emplace_back(cell_of[t], mesh.tetrahedron_interval[t], in_even_order(names));
  }
  for (const BoundaryFacet& facet : mesh.facets) {
    std::array<PointName, 3> names;
    for (int k = 0; k < 3; ++k) names[k] = out.points[facet.points[k]];
    out.facets.emplace_back(cell_of[facet.tetrahedron], facet.interval, static_cast<int>(facet.label), in_even_order(names));
  }
  for (const IntervalSummary& row : mesh.summaries) out.counts.emplace_back(row.active_cells, row.tetrahedra, row.inverted);
  std::sort(out.points.begin(), out.points.end());
  std::sort(out.tetrahedra.begin(), out.tetrahedra.end());
  std::sort(out.facets.begin(), out.facets.end());
  return out;
}

/// The same mesh with the same summaries, however its points and cells are numbered.
inline void expect_the_same(const IntervalMesh& fast, const IntervalMesh& slow) {
  const MeshContent one = content_of(fast), other = content_of(slow);
  EXPECT_EQ(one.points, other.points);
  EXPECT_EQ(one.positions, other.positions);
  EXPECT_EQ(one.tetrahedra, other.tetrahedra);
  EXPECT_EQ(one.facets, other.facets);
  EXPECT_EQ(one.counts, other.counts);
  EXPECT_EQ(fast.active_cells, slow.active_cells);
  EXPECT_EQ(fast.cells, slow.cells);
  ASSERT_EQ(fast.summaries.size(), slow.summaries.size());
  for (std::size_t i = 0; i < fast.summaries.size(); ++i) {
    EXPECT_EQ(fast.summaries[i].interval, slow.summaries[i].interval);
    EXPECT_NEAR(fast.summaries[i].volume, slow.summaries[i].volume, 1e-12 * (1 + slow.summaries[i].volume));
    EXPECT_NEAR(fast.summaries[i].signed_volume, slow.summaries[i].signed_volume, 1e-12 * (1 + slow.summaries[i].volume));
  }
}

}  // namespace isostrata
