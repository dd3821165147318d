// A port of this machine that leads to a server elsewhere.
#pragma once

#include <string>

#include "isostrata/options.h"

namespace isostrata::client {

/// `wanted`, or a free port if that one is taken and `strict` is not set. Throws ClientError.
int free_port(int wanted, bool strict);

/// A server's address at a port of this machine.
std::string address_here(const std::string& address, int port);

/// Whether a server answers at options.url, within five seconds.
bool answers(Options options);

}  // namespace isostrata::client
