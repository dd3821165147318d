// A text without the blanks around it.
#pragma once

#include <string_view>

namespace isostrata {

/// Blanks are spaces, tabs and the ends of lines.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const auto first = text.find_first_not_of(kBlanks);
  return first == std::string_view::npos ? std::string_view() : text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

}  // namespace isostrata
