// Whole numbers of a file in the width that we have them in, a part at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "import/imported/imported.h"

namespace isostrata {

/// visit(part) for integers of 4 or 8 bytes at any address, as int64, some at a time; ends with false once visit does.
template <class Visit>
bool for_parts(ScalarType type, std::span<const std::byte> values, const Visit& visit) {
  constexpr std::size_t kPart = 1u << 16;  // numbers that are looked at together
  const std::size_t element = size_of(type), count = values.size() / element;
  std::vector<std::int64_t> wide(std::min(kPart, count));
  std::vector<std::int32_t> narrow(element == 4 ? wide.size() : 0);
  for (std::size_t at = 0; at < count; at += kPart) {
    const std::size_t n = std::min(kPart, count - at);
    std::memcpy(element == 4 ? static_cast<void*>(narrow.data()) : wide.data(), values.data() + at * element, n * element);
    if (element == 4) std::copy_n(narrow.begin(), n, wide.begin());
    if (!visit(std::span<const std::int64_t>(wide).first(n))) return false;
  }
  return true;
}

}  // namespace isostrata
