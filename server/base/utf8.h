// Text from outside that may be any bytes: names of files, paths in requests.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace isostrata {

/// The bytes of the character that begins there, 1 to 4; 0 if none does: an overlong form, a surrogate, what is cut off.
std::size_t utf8_length(std::string_view text, std::size_t at);

/// The same text, each byte that belongs to no character as `escape` and two hexadecimal digits: "caf\xe9". Valid UTF-8.
std::string valid_utf8(std::string_view text, std::string_view escape = "\\x");

/// The same for JSON text, in which such bytes can stand in strings alone: those say what valid_utf8 of them says.
std::string valid_json(std::string_view text);

}  // namespace isostrata
