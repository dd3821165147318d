// The 81 cases of a tetrahedron (sorted_tetrahedron.h) in the form in which a laid out grid's are written (ordered_simd.h).
#pragma once

#include <array>

#include "extraction/unstructured/ordered_simd.h"

namespace isostrata {

/// Where the sixteen numbers that a tetrahedron may use lie: its vertices, then the crossings of its edges with the lower end,
/// then those with the upper.
inline constexpr int kLowerSlot = 4, kUpperSlot = 10;

/// [swapped][case]
using OrderedRows = std::array<std::array<CutRow, 81>, 2>;

/// alone: of a request's only interval, where the upper slots are those of edges that cross both ends. Built at the first call.
/// Any thread.
const OrderedRows& ordered_rows(bool alone);

}  // namespace isostrata
