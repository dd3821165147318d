// Extracts any number of interval volumes in one pass.
// Method: P. Bhaniramka, C. Zhang, D. Xue, R. Crawfis, R. Wenger, "Volume Interval Segmentation and Rendering", 2004, section 3.
#pragma once

#include <span>
#include <vector>

#include "base/task.h"
#include "data/dataset.h"
#include "extraction/interval_mesh.h"

namespace isostrata {

struct ExtractOptions {
  bool facets = false;      // fill IntervalMesh::facets
  std::uint64_t max_bytes = 16ull << 30;  // throws too_large, with the numbers, where the mesh would need more
};

/// Conforming: tetrahedra of neighbouring cells share whole facets, for any mix of cell types. The result does not depend on the number
/// of threads. Throws invalid_argument (lower >= upper, NaN, no interval, more than 65535), too_large, cancelled. Any thread.
IntervalMesh extract_intervals(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                               const ExtractOptions& options, const Task& task);

/// Carries another point array to the mesh's points by linear interpolation: [np].
std::vector<float> carry_array(const IntervalMesh& mesh, const PointArray& array);

}  // namespace isostrata
