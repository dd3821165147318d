// What the Host and Origin headers say of an address.
#pragma once

#include "isostrata/client.h"

namespace isostrata::client {

inline std::string host_header(const Address& address) {
  const bool v6 = address.host.find(':') != std::string::npos;
  return (v6 ? "[" + address.host + "]" : address.host) + ":" + address.port;
}

}  // namespace isostrata::client
