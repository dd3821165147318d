// Values and positions on lattice cells, for the laws that tables must keep.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "base/vec.h"
#include "tables/interval_case.h"
#include "tables/lattice_cell.h"

namespace isostrata {

/// A cell in space with a value at each vertex.
struct ValuedCell {
  LatticeCell lattice;
  std::vector<Vec3d> points;
  std::vector<double> values;

  /// Of the interval [lower, upper], upper belonging to the next one.
  int case_index(double lower, double upper) const {
    int index = 0;
    for (int v = lattice.vertex_count() - 1; v >= 0; --v) index = 3 * index + (values[v] >= lower) + (values[v] >= upper);
    return index;
  }
  Vec3d at(IsoVertex code, double lower, double upper) const {
    const int n = lattice.vertex_count(), e = lattice.edge_count();
    if (code < n) return points[code];
    const auto [a, b] = lattice.edges[(code - n) % e];
    const double isovalue = code < n + e ? lower : upper;
    return lerp(points[a], points[b], (isovalue - values[a]) / (values[b] - values[a]));
  }
  template <class Tetrahedron>
  double signed_volume(const Tetrahedron& t, double lower, double upper) const {
    return orient3d(at(t[0], lower, upper), at(t[1], lower, upper), at(t[2], lower, upper), at(t[3], lower, upper)) / 6;
  }
};

/// The lattice cell under a random right-handed affine map: its faces stay plane. Returns its volume.
inline double place_randomly(ValuedCell& cell, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Vec3d x, y, z;
  double determinant = 0;
  do {
    x = {uniform(random), uniform(random), uniform(random)};
    y = {uniform(random), uniform(random), uniform(random)};
    z = {uniform(random), uniform(random), uniform(random)};
    determinant = dot(cross(x, y), z);
  } while (determinant < 0.05);
  cell.points.clear();
  for (const LatticePoint& p : cell.lattice.vertices) cell.points.push_back(x * double(p[0]) + y * double(p[1]) + z * double(p[2]));
  const double unit = cell.lattice.name == "hexahedron" ? 1.0 : cell.lattice.name == "wedge" ? 1.0 / 2 : cell.lattice.name == "pyramid" ? 1.0 / 3 : 1.0 / 6;
  return unit * determinant;
}

}  // namespace isostrata
