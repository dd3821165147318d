// Extracts interval volumes from meshes of any cells, the fast way.
//
// Cells are looked at once: each active one leaves a small record and asks a hash table for the points that it uses. A point is
// named by its grid edge and isovalue, and numbered by the first cell that uses it, so that points lie in memory as their cells
// do. Then everything has its exact size and is written once.
#pragma once

#include <optional>
#include <span>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/extract_options.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// What extract_intervals gives, whose contract holds here too; cells in increasing order. Nothing if the way does not reach:
/// structured grids, and those where two point ids and an isovalue do not fit 64 bits or cells do not fit 32. Any thread.
std::optional<IntervalMesh> extract_unstructured(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                                 const ExtractOptions& options, const Task& task);

}  // namespace isostrata
