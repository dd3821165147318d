// Where a curvilinear grid of a file meets itself: the seam of an O-grid, whose first and last sheet of points are one place.
#pragma once

#include "import/imported/imported.h"

namespace isostrata {

/// Sets block.seams and block.jumps, and makes equal to the last bit what is equal but for rounding: a script closes a ring by the sine of 2 pi,
/// which is no 0. So what is cut on one side of the seam meets what is cut on the other (extraction/facets/weld_seams.h).
///
/// Two sheets are one if their points are no more than a millionth of the way to the next sheet apart, or 8 units of their type's
/// rounding, and no hundredth of that way. The last sheet then gets the first one's positions, and the values of each point array
/// of real numbers that differs by no more than a millionth of its range or 8 units of rounding; one that differs by more, and
/// one of whole numbers that differs at all, keeps its jump. Only what is changed is copied. Nothing for other grids.
void close_seams(Block& block);

inline bool has_seams(const Block& block) { return block.seams[0] || block.seams[1] || block.seams[2]; }

/// The point that stands for `point`: on the last sheet of a seam, that on the first.
std::int64_t without_seams(const Block& block, std::int64_t point);

}  // namespace isostrata
