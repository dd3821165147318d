// Constructive solid geometry with ranges of different arrays: ((A op B) op C) ..., exact, conforming, with labels.
//
// What is A is extracted by the interval tables. Inside a tetrahedron everything is linear, so each further array is carried to
// the mesh's points and each tetrahedron is cut where it crosses an end of the term's range (restrict_region.h). An intersection
// or a difference needs what lies in A only; a union or an exclusive or also what lies outside, which the same tables extract as
// the complement of A: one conforming mesh, of which a part is in the region so far. Cells and tetrahedra that can hold no part
// of the end result are left out as early as that is known. After: P. Bhaniramka, C. Zhang, D. Xue, R. Crawfis, R. Wenger,
// "Volume Interval Segmentation and Rendering", 2004, section 4.3.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/combine/idle_cells.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/mesh/interval_mesh.h"
#include "scene/range_term.h"

namespace isostrata {

/// Whether a chain may bring in what lies outside of A: its base must be extracted with ExtractOptions::complement.
template <class Terms>
bool needs_complement(const Terms& terms) {
  for (const auto& term : terms)
    if (adds(term.op)) return true;
  return false;
}

/// A term whose array has been carried to the mesh's points.
struct FieldTerm {
  RangeOperator op = RangeOperator::intersect;
  int field = 0;
  Interval range;
};

struct CombineOptions {
  bool facets = false;                    // fill IntervalMesh::facets; base must have its facets, too
  bool normals = false;                   // of combine_arrays, with facets: fill Combined::normals
  bool body_normals = false;              // of combine_arrays: fill Combined::body_normals
  std::uint64_t max_bytes = 16ull << 30;  // throws too_large, with the numbers, if more would be needed
};

struct Combined {
  IntervalMesh mesh;                   // without origins; values are those of fields[0]
  std::vector<Buffer<double>> fields;  // [fields][np] carried along; fields[0] is empty: it is mesh.values
  std::vector<Vec3f> normals;          // [np] of the surfaces (combined_normals.h); empty unless asked for
  std::vector<Vec3f> body_normals;     // [np] along the gradient of the first array; zero if there is none; empty unless asked for
};

/// The region of a chain of terms on a mesh that was extracted on fields[0]: the first `intervals` of its summaries are A, the
/// others its complement (see needs_complement). fields: [fields][np] of base, in double because a point on an isosurface has to
/// have just its value. Each tetrahedron keeps the interval of A it lies in; one that lies in none has the label of the term that
/// brought it in, a summary of its own (IntervalSummary::term). The labels' summaries follow the intervals' in the order of the
/// terms that add. Two ranges of different arrays, or of one, partition each other exactly: a range is closed, what is left of
/// A − B is open there. A tetrahedron that has no value (NaN, infinity) at a vertex is outside the range; facets between such and
/// others are `domain` facets. cells of base that are inverted stay so. Throws invalid_argument (a range as of IsoRules, more
/// than 65534 labels), too_large, cancelled. Any thread.
Combined combine_ranges(IntervalMesh base, std::size_t intervals, std::vector<Buffer<double>> fields,
                        std::span<const FieldTerm> terms, const CombineOptions& options, const Task& task);

/// [origins] the weight of each point's second end, in double: PointOrigin has it in single precision, so where the edge crosses
/// the isovalue is worked out again from the array that the mesh was extracted on. Precondition: the mesh has origins and values,
/// and lies on a grid with as many points as the array has values.
Buffer<double> exact_weights(const IntervalMesh& mesh, const PointArray& array);

/// The values of an array at the mesh's points: carry_array without its rounding. Throws invalid_argument (an array that is too
/// short).
Buffer<double> carry_values(const IntervalMesh& mesh, std::span<const double> weights, const PointArray& array);

/// How a base mesh is made: extract_intervals, or another triangulation of the same interval volumes.
using ExtractBase = std::function<IntervalMesh(const Grid&, const PointArray&, std::span<const Interval>, const ExtractOptions&)>;

/// The whole chain on arrays of a grid. carried: brought to the mesh's points, in their order, after fields[0].
Combined combine_arrays(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                        std::span<const ArrayTerm> terms, std::span<const PointArray* const> carried, const ExtractBase& extract,
                        const CombineOptions& options, const Task& task);

}  // namespace isostrata
