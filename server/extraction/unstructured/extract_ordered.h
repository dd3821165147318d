// Extracts interval volumes from a grid of tetrahedra that was laid out for it (ordered_tetrahedra.h).
//
// Every value is looked at once, in vectors: how many of the request's thresholds it reaches is all that cells, edges and points
// are asked afterwards. Blocks outside all intervals are left out by the least and greatest value in them. An edge has as many
// points of the mesh as thresholds lie between its ends, so points are numbered by counting, edge after edge, and a tetrahedron
// finds the numbers under those of its edges.
#pragma once

#include <optional>
#include <span>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/extract_options.h"
#include "extraction/mesh/interval_mesh.h"
#include "extraction/unstructured/ordered_tetrahedra.h"

namespace isostrata {

/// What extract_intervals gives, whose contract holds here too; cells and points in the order of `tetrahedra`. Nothing where
/// there are more than 255 different ends. Precondition: both were made of this grid and one of its arrays. Any thread.
std::optional<IntervalMesh> extract_ordered(const Grid& grid, const OrderedTetrahedra& tetrahedra, const OrderedArray& values,
                                            std::span<const Interval> intervals, const ExtractOptions& options, const Task& task);

}  // namespace isostrata
