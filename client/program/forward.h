// A port of this machine that leads to a server elsewhere.
#pragma once

#include "isostrata/options.h"

namespace isostrata::client {

/// `wanted`, or a free port if that one is taken and `strict` is not set. Throws ClientError.
int free_port(int wanted, bool strict);

/// Whether a server answers at options.url, within five seconds.
bool answers(Options options);

}  // namespace isostrata::client
