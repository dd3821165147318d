// Transfer functions as files.
#pragma once

#include <string>
#include <vector>

#include "isostrata/client.h"

namespace isostrata::client {

/// The JSON that `isostrata render --transfer` takes: {"points": [{"value": 0.2, "color": "#ff8000", "opacity": 0.1}, ...]}, or
/// that list alone. The server judges the numbers. Throws ClientError "not_found" or "bad_argument", naming the file and the
/// point.
std::vector<v1::TransferPoint> read_transfer(const std::string& path);

}  // namespace isostrata::client
