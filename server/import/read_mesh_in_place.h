// Large meshes whose arrays lie in the file nearly as they do in memory.
#pragma once

#include <optional>

#include "import/imported.h"

namespace isostrata {

/// Of .vtu: one piece of tetrahedra, hexahedra, wedges and pyramids alone, all arrays appended raw (appended_xml.h). Positions and values stay in the
/// mapped file if they are aligned there, the cells' numbers are written anew as they are checked; so the child's own memory is small. Of one that has
/// the very same mesh as ReadRequest::like only the values are taken, if all are on points. Nothing for every
/// other file, also for one that says what makes no sense: what is wrong with it is VTK's readers' to say. Throws too_large and unavailable.
std::optional<Imported> vtu_in_place(const ReadRequest& request);

}  // namespace isostrata
