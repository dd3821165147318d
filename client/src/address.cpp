#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>

#include "isostrata/client.h"

namespace isostrata::client {

Address parse_address(std::string_view text) {
  const auto parsed = boost::urls::parse_uri(text);
  if (!parsed) throw Error("address", "'" + std::string(text) + "' is not a URL; expected http://HOST:PORT/?token=TOKEN");
  if (parsed->scheme() != "http")
    throw Error("address", "'" + std::string(text) + "': only http is spoken here (reach other hosts through ssh -L), not " +
                               std::string(parsed->scheme()));
  Address address;
  address.host = parsed->host_address();
  address.port = parsed->has_port() ? std::string(parsed->port()) : "80";
  address.base = parsed->path().empty() ? "/" : parsed->path();
  if (address.base.back() != '/') address.base += '/';
  for (const auto& parameter : parsed->params())
    if (parameter.key == "token") address.token = parameter.value;
  if (address.host.empty()) throw Error("address", "'" + std::string(text) + "' names no host");
  return address;
}

}  // namespace isostrata::client
