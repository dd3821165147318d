// Numbers that are written as text.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace isostrata {

/// The number that all of the text is, without a '+' before it; nothing for another text, and for one that T cannot hold. Real numbers may be infinite or NaN.
template <class T>
std::optional<T> parsed_number(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

}  // namespace isostrata
