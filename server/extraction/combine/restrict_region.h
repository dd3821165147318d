// Cutting a mesh of tetrahedra at the ends of a range of another array, and saying of each part whether it belongs to the region.
// After the paper's section 4.3 (P. Bhaniramka et al., "Volume Interval Segmentation and Rendering", 2004): the second pass of an
// intersection extracts from the mesh of the first. Here any operator is a pass, and what lies outside the region so far is kept
// as long as a later pass may want it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "base/vec.h"
#include "extraction/mesh/interval_mesh.h"
#include "scene/range_term.h"

namespace isostrata {

inline constexpr std::uint16_t kOutsideRegion = 0xffff;  // the label of a tetrahedron that is not in the region

/// A conforming mesh with fields that are linear in each tetrahedron: all that a pass needs to know.
struct RegionMesh {
  Buffer<Vec3d> positions;                          // [np]
  std::vector<Buffer<double>> fields;               // [fields][np]; NaN and infinity: no value
  Buffer<std::array<std::uint32_t, 4>> tetrahedra;  // [nt] grouped by cell
  Buffer<std::uint16_t> labels;                     // [nt] index into the summaries, or kOutsideRegion
  Buffer<CellRun> cell_runs;                        // each cell once, and none without a tetrahedron
  /// [nt] or empty if facets are not wanted. Bit i: facet i lies on the boundary of the grid. Bit 4 + i: it may lie on the
  /// boundary of where a field has values.
  Buffer<std::uint8_t> domain_facets;

  std::int64_t points() const { return static_cast<std::int64_t>(positions.size()); }
  std::int64_t count() const { return static_cast<std::int64_t>(tetrahedra.size()); }
  std::uint64_t bytes() const;
};

/// Linear between two points of an edge; never beyond either end by rounding, and at an end just that end's value, even where the
/// other has none.
inline double value_between(double at_a, double at_b, double weight) {
  if (weight == 0 || at_a == at_b) return at_a;
  if (weight == 1) return at_b;
  const double value = at_a * (1 - weight) + at_b * weight;
  return at_a < at_b ? std::clamp(value, at_a, at_b) : at_b < at_a ? std::clamp(value, at_b, at_a) : value;
}

/// A term that knows its field and the label of what it alone brings in.
struct RegionTerm {
  RangeOperator op = RangeOperator::intersect;
  int field = 0;  // into RegionMesh::fields
  Interval range;
  std::uint16_t label = kOutsideRegion;
};

/// Applies terms[0]; the later ones say what may be dropped. A tetrahedron that crosses an end of the range is cut there, whether
/// it is in the region or not, so that all that stays still conforms: it is dropped only where no part of it can be in the region
/// at the end of the chain. Each new point carries all fields, linear along the edge it lies on, and has just the range's end in
/// the term's own field. Numbers and order of everything do not depend on threads. O(points * terms + tetrahedra).
/// Throws too_large if old and new mesh together need more than max_bytes, or more than 2^32 points or tetrahedra; cancelled.
RegionMesh restrict_region(const RegionMesh& mesh, std::span<const RegionTerm> terms, std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
