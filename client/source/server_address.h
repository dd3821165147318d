// A server's printed URL, taken apart.
#pragma once

#include <string>

#include "isostrata/options.h"

namespace isostrata::client {

struct ServerAddress {
  bool tls = false;
  std::string host;        // as a Host header has it, without the port
  std::string connect_to;  // without brackets
  std::string port;
  std::string base_path;  // "/" or "/prefix/"
  std::string token;
  std::string unix_path{};  // of a Unix socket, in place of a host and port
};

/// options.url is unix:/PATH/OF/A/SOCKET, http://HOST:PORT/ or https://HOST:PORT/, with a prefix to the path and a query if there are some; a token in
/// the query comes before options.token. Throws ClientError "bad_url".
ServerAddress parse_address(const Options& options);

}  // namespace isostrata::client
