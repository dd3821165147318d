// From the numbers of an unpacked chunk to the array's values.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "import/zarr/zarr_array.h"

namespace isostrata {

/// In the machine's byte order and of the array's type: differences summed up, halves widened, packed numbers turned into what they stand for, NaN for no value. They lie
/// in `numbers`, which is changed, or in `room`, whose storage is reused.
std::span<const std::byte> zarr_values(const ZarrArray& array, std::span<std::byte> numbers, std::vector<std::byte>& room);

}  // namespace isostrata
