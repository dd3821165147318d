// What the name of a file of raw numbers says of them: "bonsai_256x256x256_uint8.raw".
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "data/values/array.h"

namespace isostrata {

struct RawName {
  std::vector<std::int64_t> sizes;  // two to four, the fastest first; the fourth counts steps
  std::optional<ScalarType> type;   // as it says, or as the bytes of the file leave it
  bool says_type = false;
  std::optional<bool> big_endian;   // as it says
};

/// Whether the name has sizes with x between them, and an ending of such files. In small letters.
bool says_raw_sizes(std::string_view file);

/// Sizes with x between them; or three numbers of the name one after the other ("head_512_512_300_int16.raw") that are as many values as the file has bytes
/// for. Nothing if the name says none, or its ending is not one of such files. Throws bad_data if it says sizes, and the bytes are not as many.
std::optional<RawName> raw_name(std::string_view file, std::uint64_t bytes);

/// "uint8", "u8", "uchar", "float" and the like, in small letters.
std::optional<ScalarType> scalar_type_named(std::string_view word);

}  // namespace isostrata
