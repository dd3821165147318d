// Tables for simplices whose vertices come in the order of their global numbers: intervals, and slices.
//
// In a simplex the field is linear, so the interval volume is one convex polytope whose faces depend on the case only, and so is
// a slice. Both are triangulated by *pulling* in the order of the vertices: the smallest vertex is joined to the facets that it
// is not in, and these are treated alike. That needs no more than which facet holds which vertex, so it is valid whatever the
// values are, and simplices that share a facet cut it alike. Source: J. A. De Loera, J. Rambau, F. Santos, "Triangulations",
// 2010, section 4.3.2.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tables/interval_case.h"

namespace isostrata {

/// The interval table of the n-simplex 0, e1, ..., en, its 3^(n+1) cases as in interval_case.h.
struct SimplexTable {
  int dimension = 0;
  std::vector<FaceMask> masks;                                         // [n + 1 + n (n + 1)] of the isovertices
  std::vector<std::uint64_t> isovertices;                              // [cases] set of those in use, bit i for isovertex i
  std::vector<std::uint32_t> first;                                    // [cases + 1] into simplices
  std::vector<std::array<IsoVertex, kMaxLatticeDimension>> simplices;  // [dimension + 1] used, positively oriented

  std::span<const std::array<IsoVertex, kMaxLatticeDimension>> of(int case_index) const {
    return {simplices.data() + first[case_index], simplices.data() + first[case_index + 1]};
  }
};

/// n = 2, ..., 5. Built at the first call for each n (milliseconds); later calls cost nothing. Any thread.
/// 309 simplices in all for the tetrahedron, 1851 for the 4-simplex: fewer than by placing (321 and 2031).
const SimplexTable& simplex_table(int n);

/// One simplex of a slice, as crossed edges of the sliced simplex.
struct SliceSimplex {
  std::array<std::uint8_t, kMaxLatticeDimension> edge{};  // [n] in the numbering of lattice_simplex(n).edges
  std::array<std::int8_t, kMaxLatticeDimension> facet{};  // [n] facet i is opposite edge[i]: the one of the sliced simplex that
                                                          // it lies in, named by the vertex that is not in it; -1 inside
};

/// The isosurface table of the n-simplex: what a hyperplane cuts out of it. Case: bit v is set where vertex v is above. The
/// slice is the product of the simplex of the vertices below and that of those above, cut along the ascending paths (H.
/// Freudenthal, "Simplizialzerlegungen von beschraenkter Flachheit", 1942). Oriented so that, where the sliced simplex is
/// positive in coordinates of which the last is the height, the slice's simplices are positive in the others.
struct SliceTable {
  int dimension = 0;
  std::vector<std::uint32_t> first;  // [2^(n+1) + 1] into simplices
  std::vector<SliceSimplex> simplices;

  std::span<const SliceSimplex> of(unsigned above) const {
    return {simplices.data() + first[above], simplices.data() + first[above + 1]};
  }
};

/// n = 2, ..., 5. Built at the first call for each n; later calls cost nothing. Any thread.
const SliceTable& slice_table(int n);

}  // namespace isostrata
