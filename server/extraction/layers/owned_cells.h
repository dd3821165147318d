// Of a mesh that was extracted from a part of a grid: what lies in the cells that the part owns. The cells of its margin are owned by others,
// who count and write them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/grids/region_tree.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Called from any thread.
using OwnsCell = std::function<bool(std::int64_t cell)>;

/// The owner of a cell is the region of its first corner, whichever part of the whole it is looked at in. Grid and regions must outlive what is
/// returned.
OwnsCell owner_of(const Grid& grid, const RegionTree& regions, int region);

/// The mesh's summaries as its owned cells alone make them. What owners of all cells count adds up to what one extraction of the whole grid
/// counts; volumes to rounding. O(tetrahedra). Precondition: the grid is not flat. Throws cancelled.
std::vector<IntervalSummary> owned_summaries(const Grid& grid, const IntervalMesh& mesh, const OwnsCell& owns, const Task& task);

struct OwnedPart {
  IntervalMesh mesh;                  // without origins and inner points; its cells are the owned ones
  std::vector<std::uint32_t> points;  // [np] their numbers in the mesh that it was taken from
};

/// Tetrahedra, facets and points of the owned cells, in their order. Same precondition, same errors.
OwnedPart owned_mesh(const Grid& grid, const IntervalMesh& mesh, const OwnsCell& owns, const Task& task);

}  // namespace isostrata
