// The intervals of a flat grid: areas in place of volumes.
// Method: P. Bhaniramka, C. Zhang, D. Xue, R. Crawfis, R. Wenger, "Volume Interval Segmentation and Rendering", 2004, Figure 1.
#pragma once

#include <span>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/extract_options.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// The grid is flat. The mesh has no tetrahedra; its facets are the triangles of the areas, labelled `domain`, by cell and then by interval,
/// turned as their cells are, and summaries count and measure them. Neighbouring cells share whole edges. Of the options `values`,
/// `measure`, `complement` and `max_bytes` apply. Throws as extract_intervals. Any thread.
IntervalMesh extract_areas(const Grid& grid, const PointArray& array, std::span<const Interval> intervals, const ExtractOptions& options,
                           const Task& task);

}  // namespace isostrata
