// One case of an interval table: the simplices of the interval volume in one cell, for one classification of the cell's vertices.
// Method: P. Bhaniramka, C. Zhang, D. Xue, R. Crawfis, R. Wenger, "Volume Interval Segmentation and Rendering", 2004, section 3:
// the cell C is lifted to C x [0,1] with f - lower at t = 0 and f - upper at t = 1; the isosurface 0 of the lifted cell, made of
// hull facets as in P. Bhaniramka, R. Wenger, R. Crawfis, "Isosurface construction in any dimension using convex hulls", 2004,
// projects one to one onto the interval volume.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tables/lattice_cell.h"

namespace isostrata {

/// A vertex's class: 0 below the interval, 1 inside, 2 above.
/// A case is the number whose base-3 digit v (weight 3^v) is the class of vertex v.
/// 3^vertex_count, for up to 39 vertices.
std::int64_t case_count(int vertex_count);

/// A vertex of the interval volume, as a number below n + 2 e for a cell of n vertices and e edges:
///   v                the cell's vertex v, which is inside;
///   n + i            edge i crosses the lower isovalue there;
///   n + e + i        edge i crosses the upper isovalue there.
using IsoVertex = std::uint8_t;

/// Which facets of the lifted cell hold a vertex: bit 0 the lower isosurface (t = 0), bit 1 the upper one (t = 1), bit 2 + k the
/// cell's face k. The label of a facet of a simplex is the AND over its vertices; 0 means inside the cell.
using FaceMask = std::uint16_t;
inline constexpr FaceMask kOnLower = 1;
inline constexpr FaceMask kOnUpper = 2;
inline constexpr int kFirstFaceBit = 2;

/// The masks of all isovertices: [n + 2 e].
std::vector<FaceMask> face_masks(const LatticeCell& cell);

/// The hull facets that make the isosurface of the lifted cell, as simplices of the interval volume. Simplices of equal `plane`
/// lie in one hyperplane of the lifted space and make up one convex polytope of the interval volume, whatever the order of
/// placing was.
struct IsoSimplex {
  std::array<IsoVertex, kMaxLatticeDimension> vertex{};  // [dimension + 1], positively oriented in the cell's own coordinates
  int plane = 0;
};

enum class HullSide { positive, negative };

/// The order in which points are placed, and whose hull is taken. The choice changes the number of simplices, never the region.
struct PlacingRule {
  HullSide side = HullSide::negative;
  bool t_first = true;   // the lifted coordinate is compared first (else last)
  bool x_first = false;  // of the cell's coordinates x is compared first (else last)
};

/// The fewest simplices found for the hexahedron: 78336 over all cases, at most 18 (as published: 79344 and 22).
inline constexpr PlacingRule kTableRule{};

/// Cells of 2, 3, 4 and 5 dimensions. O(hull points * facets of the hull): microseconds in 3-D, up to a second for the 5-cube, whose
/// lifted hull has up to 192 points. Any thread.
std::vector<IsoSimplex> interval_case(const LatticeCell& cell, std::int64_t case_index, const PlacingRule& rule = kTableRule);

}  // namespace isostrata
