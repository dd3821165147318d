// What a call of the C++ client refused.
#pragma once

#include <string>

#include "isostrata/client.h"

namespace isostrata::testing {

/// The code of the ClientError that the call throws; empty if it throws none.
template <class Call>
std::string code_of(const Call& call) {
  try {
    call();
  } catch (const client::ClientError& error) {
    return error.code();
  }
  return "";
}

}  // namespace isostrata::testing
