// What a request's target says: a path in clean segments and query parameters.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isostrata {

struct RequestTarget {
  std::vector<std::string> segments;  // decoded; never empty, ".", "..", nor with a slash, backslash or control character inside
  bool trailing_slash = false;        // or no segment at all
  std::map<std::string, std::string> query;  // decoded; each name once

  std::string path() const;  // "/a/b" from the segments, "/" if there is none
};

/// Nothing if the target is not an origin-form path or hides something: bad escapes, "..", empty segments, NUL, a query
/// parameter that stands twice, over 8192 bytes.
std::optional<RequestTarget> parse_target(std::string_view target);

/// Decodes %xx; nothing if an escape is broken or gives a control character.
std::optional<std::string> decode_percent(std::string_view text, bool plus_is_space);
std::string encode_percent(std::string_view text);

}  // namespace isostrata
