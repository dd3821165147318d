// Which facets of the tetrahedra bound an interval, and a check that all others meet a partner.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/mesh/interval_mesh.h"
#include "tables/interval_case.h"

namespace isostrata {

/// For each facet of a tetrahedron (facet i is opposite vertex i) where it lies.
using FacetLabels = std::array<std::uint8_t, 4>;
inline constexpr std::uint8_t kInsideCell = 0;
inline constexpr std::uint8_t kLowerFacet = 1;
inline constexpr std::uint8_t kUpperFacet = 2;
inline constexpr std::uint8_t kFirstCellFace = 3;  // + k: in the cell's face k

/// From the masks of a tetrahedron's vertices.
FacetLabels label_facets(FaceMask a, FaceMask b, FaceMask c, FaceMask d);

/// For each of these cells its faces that no other cell shares, bit k for face k; hidden and absent cells do not count as sharing.
/// Precondition: on unstructured grids, where another cell shares such a face it is one of these cells, too. Throws too_large,
/// cancelled.
std::vector<std::uint8_t> open_cell_faces(const Grid& grid, const PointArray& array, std::span<const CellRun> runs,
                                          std::uint64_t max_bytes, const Task& task);

/// Facets on the lower and upper isosurfaces, and those in cell faces that no other cell shares. Hidden and absent cells do not
/// count as sharing. labels: [nt]. In the order of the tetrahedra. Throws too_large, cancelled.
Buffer<BoundaryFacet> boundary_facets(const Grid& grid, const PointArray& array, const IntervalMesh& mesh,
                                           std::span<const FacetLabels> labels, std::uint64_t max_bytes, const Task& task);
/// The same where open_cell_faces of the mesh's runs is known.
Buffer<BoundaryFacet> boundary_facets(const IntervalMesh& mesh, std::span<const FacetLabels> labels, std::span<const std::uint8_t> open,
                                           std::uint64_t max_bytes, const Task& task);

/// Facets of tetrahedra that are not in mesh.facets and do not meet exactly one other such facet of the same interval, with
/// opposite orientation; where such facets meet facets of mesh.facets all of them count. 0 for a conforming mesh. Precondition:
/// the mesh was extracted with facets. O(tetrahedra) expected; about 9 bytes for each beside 4 MB. Throws cancelled.
std::int64_t count_unmatched_facets(const IntervalMesh& mesh, const Task& task);

}  // namespace isostrata
