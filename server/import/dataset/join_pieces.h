// Points that pieces of one grid share, each written by every piece that has it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "import/imported/imported.h"

namespace isostrata {

/// Makes one point of those of different pieces that are at the same place and have the same values in every point array, both but for rounding
/// (near_points.h, near_values.h), or no value if the other one's piece has no such array: so cells of different pieces meet in common points, and
/// nothing is a boundary where one piece goes on as another. The first one's place and values are kept. Where values differ, the field has a jump
/// there, and the points stay apart. Points of one piece are never joined. A cell that another piece has as well, point for point, is hidden,
/// unless it is already. Points keep their order.
///
/// global_points: [points] or empty. Where it says which points of a whole they are, only points of one number become one, and they are put in the
/// order of those numbers, and no cell is hidden: so a grid that was parted is cut as it was before.
///
/// first_points: [pieces] the number of each piece's first point; first_cells alike. An unstructured block, whose arrays are
/// whole. Notes say what was joined, left apart and hidden. O(points log points), 32 bytes for each.
void join_pieces(Block& block, std::span<const std::int64_t> first_points, std::span<const std::int64_t> first_cells,
                 std::span<const std::int64_t> global_points, std::vector<std::string>& notes);

}  // namespace isostrata
