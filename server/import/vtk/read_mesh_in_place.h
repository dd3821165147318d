// Meshes whose arrays are read past VTK's reader.
#pragma once

#include <optional>

#include "import/imported/imported.h"

namespace isostrata {

/// Of .vtu: one piece of tetrahedra, hexahedra, wedges and pyramids alone, all of whose arrays xml_arrays.h finds. Positions and values that lie
/// there as in memory stay in the mapped file if they are aligned, the cells' numbers are written anew as they are checked. Of one that has
/// the very same mesh as ReadRequest::like only the values are taken, if all are on points. Nothing for every
/// other file, also for one that says what makes no sense: what is wrong with it is VTK's readers' to say. Throws too_large and unavailable.
std::optional<Imported> vtu_in_place(const ReadRequest& request);

}  // namespace isostrata
