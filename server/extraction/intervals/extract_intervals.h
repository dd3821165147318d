// Extracts any number of interval volumes in one pass.
// Method: P. Bhaniramka, C. Zhang, D. Xue, R. Crawfis, R. Wenger, "Volume Interval Segmentation and Rendering", 2004, section 3.
#pragma once

#include <span>
#include <vector>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/extract_options.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Generates the tables that the grid's cells need, where this process has not done so yet (0.1 s for hexahedra).
/// extract_intervals does it too; this is for whoever wants to pay, or time, it apart. Any thread.
void prepare_tables(const Grid& grid);

/// Conforming: tetrahedra of neighbouring cells share whole facets, for any mix of cell types. The result does not depend on the
/// number of threads. A cell that is hidden, or has a vertex whose value or position is not finite, holds no part of any
/// interval; its neighbours' faces towards it bound the domain. Of a flat grid the areas come (extract_areas.h). Ends may be
/// infinite. Throws invalid_argument (lower >= upper, an end that is NaN, no interval, more than 65535, an array of another
/// length than the grid's points), too_large, cancelled. Any thread.
IntervalMesh extract_intervals(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                               const ExtractOptions& options, const Task& task);

/// The same, in the one way that any grid and any number of intervals can go: for what extract_structured.h and
/// extract_unstructured.h do not reach, and what the fast ways are tested against. Points and cells may be numbered differently.
IntervalMesh extract_in_general(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                const ExtractOptions& options, const Task& task);

/// Carries another point array to the mesh's points by linear interpolation: [np].
std::vector<float> carry_array(const IntervalMesh& mesh, const PointArray& array);

}  // namespace isostrata
