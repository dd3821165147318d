// The unit that a file says an array's values are in. It travels as one of Dataset::notes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace isostrata {

/// The note. unit: as the file says it; empty: there is no note.
void note_unit(std::vector<std::string>& notes, std::string_view array, std::string_view unit);

/// What the first such note says of the array; empty: there is none.
std::string unit_of(const std::vector<std::string>& notes, std::string_view array);

/// "temperature (K)"; the name alone where there is no unit.
std::string name_with_unit(const std::vector<std::string>& notes, std::string_view array);

}  // namespace isostrata
