// One case of an interval table as a drawing: the cell, its vertices by class, and the simplices of its interval volume.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tables/lattice_cell.h"

namespace isostrata {

/// "02020202": the classes of the vertices in their order, 0 below the interval, 1 inside, 2 above; or the number of the case, as
/// interval_case.h counts. Throws invalid_argument.
std::int64_t parse_case(const LatticeCell& cell, std::string_view text);

/// An SVG of the cell in a fixed parallel view: black vertices are above the interval, white ones below, grey ones inside. The simplices of
/// cells of two and three dimensions are filled, each moved a little away from the middle so that all can be seen. Of cells of more
/// dimensions there is the cell alone: the fourth coordinate moves a vertex along a direction of its own, with edges along it in maroon,
/// those at its start in green and those at its end in blue, as the paper's Figure 3 has them.
std::string draw_case(const LatticeCell& cell, std::int64_t case_index);

/// A line for each simplex: its corners as "v3" (a vertex), "1-5 lower" or "1-5 upper" (where that edge crosses an end).
std::string describe_case(const LatticeCell& cell, std::int64_t case_index);

}  // namespace isostrata
