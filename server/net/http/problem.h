// Errors of the HTTP side: RFC 9457 problem documents.
#pragma once

#include <string>

#include "isostrata/v1/isostrata.pb.h"
#include "net/http/http_message.h"

namespace isostrata {

/// {"type", "title", "status", "detail", "code", "field"?, "hint"?}. `code` is that of the WebSocket's Error, or one that only
/// HTTP has: "unauthorized", "forbidden", "precondition_failed". The status follows from the code.
HttpResponse problem(const v1::Error& error);
/// The same with another status (405, 415, ...).
HttpResponse problem(int status, const std::string& code, const std::string& message, const std::string& field = {});

/// "Not Found" for 404.
const char* status_phrase(int status);

}  // namespace isostrata
