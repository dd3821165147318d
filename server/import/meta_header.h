// The header of a MetaImage, read as VTK's reader (MetaIO) reads it: Insight Software Consortium, https://itk.org/Wiki/MetaIO/Documentation.
#pragma once

#include <cstdint>
#include <functional>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "data/array.h"

namespace isostrata {

struct MetaHeader {
  std::map<std::string, std::string, std::less<>> fields;  // the last of each name
  std::string data;                                        // what ElementDataFile says; never empty
  std::uint64_t end = 0;                                   // where what is behind the header begins

  /// Empty where there is none of the name.
  std::string_view field(std::string_view name) const;
  /// Whether the values are behind the header, in the same file.
  bool local() const { return data == "LOCAL" || data == "Local" || data == "local"; }
  /// Nothing where ElementType is none, or one whose size is not the same everywhere (MET_LONG).
  std::optional<ScalarType> type() const;
  /// Of the values, when they are unpacked; nothing where the fields that say so make no sense.
  std::uint64_t declared_bytes() const;
};

/// Reads from the beginning up to the line of ElementDataFile; `in` stands behind it then. A name begins where its line's blanks end and ends at the first = or :, a value
/// begins behind all of these and the blanks that follow. What MetaIO would take otherwise is refused: a line without a value, whose value it would
/// look for in the next line; a control character; a line above 499 bytes, which ends its reading. Throws bad_data.
MetaHeader read_meta_header(std::istream& in, std::string_view file);

}  // namespace isostrata
