// A server's printed URL, taken apart.
#pragma once

#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>
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
};

inline ServerAddress parse_address(const Options& options) {
  const auto url = boost::urls::parse_uri(options.url);
  if (!url || (url->scheme() != "http" && url->scheme() != "https") || url->host().empty())
    throw ClientError("bad_url", "'" + options.url.substr(0, options.url.find('?')) +
                                     "' is not a server's address; expected http://HOST:PORT/ or https://HOST:PORT/");
  ServerAddress address;
  address.tls = url->scheme() == "https";
  address.host = url->encoded_host();
  address.connect_to = url->host_address();
  address.port = url->has_port() ? std::string(url->port()) : address.tls ? "443" : "80";
  address.base_path = url->encoded_path();
  if (!address.base_path.ends_with('/')) address.base_path += '/';
  address.token = options.token;
  for (const auto& parameter : url->params())
    if (parameter.key == "token") address.token = parameter.value;
  return address;
}

}  // namespace isostrata::client
