// Convex hulls of a few lattice points in up to six dimensions, exactly, with the boundary triangulated by *placing*.
//
// Placing (pushing) triangulation: points are added one at a time; each new point is joined to the facets that it sees strictly,
// and facets whose hyperplane holds it are left alone. Restricted to any face of the hull it is the placing triangulation of that
// face's points in the same order, which is why cells that share a face and order its points alike agree on it. Source: J. A. De
// Loera, J. Rambau, F. Santos, "Triangulations", 2010, section 4.3.1.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isostrata {

inline constexpr int kMaxLatticeDimension = 6;
inline constexpr int kMaxHullPoints = 255;  // the lifted 5-cube has up to 192

/// Coordinates past the dimension in use are 0. Magnitudes up to 8 leave every determinant far inside 64 bits.
using LatticePoint = std::array<int, kMaxLatticeDimension>;

/// One simplex of the triangulated boundary.
struct HullFacet {
  /// [dimension] point indices. det(v1 - v0, ..., v[d-1] - v0, normal) > 0.
  std::array<std::uint8_t, kMaxLatticeDimension> vertex{};
  /// Outward and primitive (its components share no factor), so that simplices in one hyperplane have equal normal and offset.
  std::array<std::int64_t, kMaxLatticeDimension> normal{};
  std::int64_t offset = 0;  // normal . x of every point of the hyperplane
};

/// The boundary of the hull of `points` in R^dimension, placed in the order given.
/// Preconditions: 2 <= dimension <= 6; at most kMaxHullPoints points, each a vertex of the hull of all; together they span
/// R^dimension. O(points * facets). Any thread.
std::vector<HullFacet> placing_hull(std::span<const LatticePoint> points, int dimension);

}  // namespace isostrata
