// The header of a MetaImage, read as VTK's reader (MetaIO) reads it: Insight Software Consortium, https://itk.org/Wiki/MetaIO/Documentation.
#pragma once

#include <cstdint>
#include <functional>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "data/values/array.h"

namespace isostrata {

struct MetaHeader {
  std::map<std::string, std::string, std::less<>> fields;  // the last of each name
  std::string data;                                        // what ElementDataFile says; never empty
  std::uint64_t end = 0;                                   // where what is behind the header begins

  /// Empty if there is none of the name.
  std::string_view field(std::string_view name) const;
  /// Whether the values are behind the header, in the same file.
  bool local() const { return data == "LOCAL" || data == "Local" || data == "local"; }
  /// Nothing if ElementType is none. MET_LONG has four bytes everywhere, as MetaIO and ITK have it.
  std::optional<ScalarType> type() const;
  /// DimSize, of one to three axes, each of a point or more; else empty.
  std::vector<std::int64_t> sizes() const;
  /// Numbers in each point; nothing if that makes no sense.
  std::optional<std::int64_t> channels() const;
  bool compressed() const { return says_yes(field("CompressedData")); }
  bool big_endian() const { return says_yes(field("BinaryDataByteOrderMSB")) || says_yes(field("ElementByteOrderMSB")); }
  /// As MetaIO has it, yes if nothing is said.
  bool binary() const { return field("BinaryData").empty() || says_yes(field("BinaryData")); }
  /// Of the values, when they are unpacked; nothing if the fields that say so make no sense.
  std::uint64_t declared_bytes() const;

 private:
  static bool says_yes(std::string_view text);
};

/// Reads from the beginning up to the line of ElementDataFile; `in` stands behind it then. A name begins where its line's blanks end and ends at the first = or :, a value
/// begins behind all of these and the blanks that follow. What MetaIO would take otherwise is refused: a line without a value, whose value it would
/// look for in the next line; a control character; a line above 499 bytes, which ends its reading. Throws bad_data.
MetaHeader read_meta_header(std::istream& in, std::string_view file);

}  // namespace isostrata
