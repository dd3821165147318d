// NRRD's header of what other headers say (images/read_nrrd.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/error.h"
#include "import/images/nrrd_header.h"
#include "import/imported/imported.h"

namespace isostrata {

/// One more axis, slower than those before. Throws bad_data for a size below 1, and if there are more than 2^62 values then.
inline NrrdAxis& add_axis(NrrdHeader& header, std::int64_t size, NrrdRole role, const std::string& name) {
  if (size < 1) throw Error(ErrorCode::bad_data, name + ": an axis of " + std::to_string(size) + " points; expected at least 1");
  std::int64_t all = size;
  for (const NrrdAxis& axis : header.axes) all = checked_product({all, axis.size}, name);
  NrrdAxis& axis = header.axes.emplace_back();
  axis.size = size;
  axis.role = role;
  return axis;
}

}  // namespace isostrata
