// What VTK's legacy reader does not check.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace isostrata {

/// Points and coordinates are at least a byte each: throws bad_data if the first 1 MB declares more of them than the file has bytes, with which VTK 9.1
/// reckons until it is beyond its memory.
void check_legacy_counts(std::span<const std::byte> file, const std::string& name);

/// "CELLS n size" of a legacy file is followed by `size` integers: for each of the n cells the number of its points and their
/// ids. VTK 9.1 walks them without looking where they end, so a wrong number makes it read beyond its memory and hand over what
/// it finds there. Throws bad_data if the numbers do not add up. Files of version 5, whose cells have OFFSETS, pass: their
/// offsets are checked once read.
void check_legacy_cells(std::span<const std::byte> file, const std::string& name);

}  // namespace isostrata
