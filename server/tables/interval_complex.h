// The interval volume inside one cell as convex polytopes, and its triangulation by *pulling* in an order chosen at run time.
//
// The hull facets that make the lifted cell's isosurface are convex 3-polytopes; which ones depends on the case only. On a cell face they
// leave convex polygons that depend on that face's classes only. So the polytopes of neighbouring cells conform before anything is
// triangulated, and it is enough to triangulate with an order of points that all cells share: in each polytope the smallest vertex is joined
// to the triangles of the faces that it is not in, each face being fanned from its own smallest vertex.
// Source: J. A. De Loera, J. Rambau, F. Santos, "Triangulations", 2010, section 4.3.2 (pulling).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tables/interval_case.h"

namespace isostrata {

inline constexpr int kMaxCaseTetrahedra = 64;
inline constexpr int kMaxIsoVertices = 32;  // of a 3-D cell: the hexahedron has 8 vertices and 12 edges, each crossed by two isovalues

/// Polytopes of every case of a cell type.
struct IntervalComplex {
  CellType type;
  std::vector<FaceMask> masks;             // [n + 2 e] of the isovertices
  std::vector<std::uint32_t> isovertices;  // [cases] set of those in use, bit i for isovertex i
  std::vector<std::uint32_t> first;        // [cases + 1] into code
  /// For each polytope of a case: its number of faces, then for each face its number of vertices and these, counter-clockwise seen from
  /// outside the polytope (in a right-handed cell).
  std::vector<IsoVertex> code;
};

/// Built at the first call for each type; later calls cost nothing. Any thread.
const IntervalComplex& interval_complex(CellType type);

/// The order of a cell's isovertices that all cells share: vertices of the cell by global point id, then crossings by the edge's lower and
/// upper global id, then lower before upper isovalue. Equal global ids (collapsed cells) are told apart by local number, which only
/// decides where tetrahedra without extent lie.
/// keys: [n + 2 e], distinct, smaller first.
void order_isovertices(const CellTopology& cell, std::span<const std::int64_t> point_ids, std::span<std::uint8_t> keys);

/// Writes the case's tetrahedra, positively oriented in a right-handed cell, and returns how many. `out` has room for kMaxCaseTetrahedra.
/// O(vertices of the complex).
int pull(const IntervalComplex& complex, int case_index, std::span<const std::uint8_t> keys, std::array<IsoVertex, 4>* out);

}  // namespace isostrata
