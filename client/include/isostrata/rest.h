// The server's REST interface (api/v1), for what is one question and one answer. Each call opens a connection of its own.
#pragma once

#include <iosfwd>
#include <string>

#include "isostrata/options.h"

namespace isostrata::client {

struct HttpAnswer {
  int status = 0;
  std::string content_type;
  std::string etag;  // with its quotes; empty: none
  std::string body;
};

/// Sends one request below the server's base URL ("api/v1/sessions"), with its token. A body goes as JSON; `if_match` is a
/// revision's ETag, with its quotes. Throws ClientError: for a status of 400 or more with the problem document's code, detail and
/// field.
HttpAnswer http_request(const Options& options, const std::string& method, const std::string& path, const std::string& body = "",
                        const std::string& if_match = "");

/// The body of a GET.
std::string http_get(const Options& options, const std::string& path);
/// The body of a GET, written as it comes.
void http_download(const Options& options, const std::string& path, std::ostream& to);

}  // namespace isostrata::client
