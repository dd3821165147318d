// The hexahedron's interval table as the compute shaders read it.
#pragma once

#include <cstdint>
#include <vector>

namespace isostrata {

/// ISO_VERTICES words that say where each isovertex lies, HEXAHEDRON_CASES words that say which tetrahedra a case has, and these,
/// four isovertices a word: shaders/layout.h has the bits. Makes the table at the first call (hexahedron_table). Any thread.
std::vector<std::uint32_t> table_words();

}  // namespace isostrata
