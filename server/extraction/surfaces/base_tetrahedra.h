// A grid of tetrahedra as one mesh that serves any intervals of an array: what is drawn of it is cut when it is drawn.
//
// A value f of single precision lies in an interval where begin <= f < end: with those two floats (value_bounds) the rule of the
// ends (Interval) needs no special cases, and a tetrahedron is active in just the intervals that its least and greatest value
// tell.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

struct ValueBounds {
  float begin = 0, end = 0;
};
/// [intervals]. An interval that ends where another begins leaves the shared value to that one.
std::vector<ValueBounds> value_bounds(std::span<const Interval> intervals);

/// Least and greatest value; of nothing least > most.
struct TetrahedronRanges {
  static constexpr std::size_t kBlock = 64;
  Buffer<float> least, most;              // [nt, padded to whole blocks with nothing]
  Buffer<float> block_least, block_most;  // [blocks]

  bool block_reaches(std::size_t block, const ValueBounds& of) const {
    return block_most[block] >= of.begin && block_least[block] < of.end;
  }
  bool reaches(std::size_t tetrahedron, const ValueBounds& of) const {
    return (most[tetrahedron] >= of.begin) & (least[tetrahedron] < of.end);  // no branch: neighbours differ
  }
};

/// Immutable, shared between threads; holds nothing of the dataset.
struct BaseTetrahedra {
  /// The grid's tetrahedra that take part (not those that extraction leaves out) in the order of CellClusters, points in the
  /// order of their first use, vertices ordered so that the volume is positive. Of the buffers only positions and tetrahedra;
  /// facets: the domain's boundary; no summaries.
  std::shared_ptr<const IntervalMesh> mesh;
  std::shared_ptr<const std::vector<float>> values;  // [np]
  TetrahedronRanges ranges;
  Buffer<double> volume, block_volume;  // [nt, padded with zeros], [blocks]

  std::uint64_t bytes() const;
};

/// Whether all cells are tetrahedra, so that there can be such a mesh.
bool only_tetrahedra(const Dataset& dataset);

/// The most that making it takes, bytes.
std::uint64_t base_tetrahedra_bytes(const Dataset& dataset);

/// Throws unsupported (other cells), not_found, too_large, cancelled. O(cells log cells), parallel. Any thread.
std::shared_ptr<const BaseTetrahedra> make_base_tetrahedra(const Dataset& dataset, const std::string& array,
                                                           std::uint64_t max_bytes, const Task& task);

/// Whether single precision tells the interval's ends apart from what lies between them: a few thousand steps.
bool resolves(const BaseTetrahedra& base, const Interval& interval);

/// As extraction sums them: active cells (here also called tetrahedra, for they are not split) and the exact volume of the
/// field's linear pieces. Blocks outside are not looked into. Parallel.
std::vector<IntervalSummary> measure_intervals(const BaseTetrahedra& base, std::span<const Interval> intervals);

/// The share of a tetrahedron with these values, sorted from the least, in which the linear field is below `value`.
double share_below(const double (&f)[4], double value);

}  // namespace isostrata
