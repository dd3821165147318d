// NRRD's header. The format: G. Kindlmann, "Definition of NRRD File Format", teem.sourceforge.net/nrrd/format.html.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "data/values/array.h"

namespace isostrata {

enum class NrrdEncoding { raw, text, hex, gzip, bzip2 };

/// What an axis means to us.
enum class NrrdRole { space, component, time };

struct NrrdAxis {
  std::int64_t size = 1;
  NrrdRole role = NrrdRole::space;
  std::string kind, unit;                       // as written, empty if not given
  std::optional<double> spacing, lower, upper;  // "spacings", "axis mins", "axis maxs"; absent if not given or nan
  bool cell_centered = false;
  std::optional<std::array<double, 3>> direction;  // "space directions"; absent for none
};

struct NrrdHeader {
  ScalarType type = ScalarType::uint8;
  NrrdEncoding encoding = NrrdEncoding::raw;
  bool big_endian = false;
  std::vector<NrrdAxis> axes;                   // fastest first
  std::optional<std::array<double, 3>> origin;  // "space origin"
  std::int64_t line_skip = 0, byte_skip = 0;
  std::string unit;                     // "sample units"
  std::array<std::string, 3> space_units;  // of the axes of the space that origin and directions are in
  std::vector<std::string> data_files;  // empty: the data follow the header
  std::size_t length = 0;               // bytes of header, blank line included

  std::int64_t values() const;  // product of the sizes; checked when parsed
};

/// text: the file's beginning, or all of it. Throws bad_data naming the field, unsupported (block type, an encoding we lack).
NrrdHeader parse_nrrd_header(std::string_view text, const std::string& name);

}  // namespace isostrata
