// What every answer tells the browser that it must not do with it.
#pragma once

#include "net/http/http_message.h"

namespace isostrata {

/// Of an answer, whoever gives it; a page's are more.
HttpHeaders security_headers(const HttpResponse& response);

/// The style of the small pages that the server writes itself, which the policy names by its hash.
inline constexpr std::string_view kPageStyle =
    "body{font:16px/1.5 system-ui,sans-serif;max-width:40em;margin:4em auto;padding:0 1em}";

}  // namespace isostrata
