// The laws that every extracted mesh keeps, checked on the mesh as it is.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

struct BrokenLaw {
  std::string law;         // "unmatched facets", ...
  std::int64_t count = 0;  // how often it is broken
  std::string first;       // the first place: what, where, and what was expected
};

struct LawOptions {
  bool one_range = true;  // the intervals are ranges of the array in IntervalMesh::values, not combined with others; of whole values there are none
  bool strict = false;    // no tetrahedron is turned but in tangled cells
};

/// All that are broken, none for a mesh that is right:
///   points             every number names a point, every position is finite; every tetrahedron has its cell
///   unmatched facets   a facet that does not bound its interval meets one other of that interval (count_unmatched_facets)
///   closed boundary    each edge of an interval's boundary has an even number of its facets
///   labels             a boundary facet is one of its tetrahedron's, and of its interval; with one_range the points of a lower
///                      (upper) one have just that value
///   values             with one_range: no point of a tetrahedron has a value outside its interval
///   bounds             no tetrahedron reaches out of the box around its cell
///   sums               the summaries are the tetrahedra's counts, volumes, signed volumes and turned ones; the two volumes
///   differ
///                      just where some are turned
///   strict             turned tetrahedra are in as many cells as are tangled, at most
/// Precondition: extracted with facets, values and measure on this grid. O(tetrahedra + facets log). Throws cancelled. Any
/// thread.
std::vector<BrokenLaw> check_laws(const Grid& grid, const IntervalMesh& mesh, const LawOptions& options, const Task& task);

struct Partition {
  double error = 0;   // relative
  double volume = 0;  // of the cells, as bounded by the pieces' domain facets
};

/// Whether the intervals, with what is below, between and above them, tile the cells of the mesh: those cells are extracted
/// again, all pieces in one conforming pass, and the sum of their signed volumes is compared with the volume enclosed by the
/// facets in which they meet what is not among these cells (by the divergence theorem: exact for warped faces, too). The
/// difference is what pieces overlap or leave open. Intervals that overlap are taken in as many passes as it needs. In batches of
/// cells, so that the memory is bounded. Empty if the mesh has no tetrahedra. Throws what extract_intervals throws, and
/// internal if a cell of the mesh is in no piece.
std::optional<Partition> partition_error(const Grid& grid, const PointArray& array, const IntervalMesh& mesh,
                                         const ExtractOptions& options, const Task& task);

}  // namespace isostrata
