// Transfer functions as files.
#pragma once

#include <filesystem>
#include <vector>

#include "scene/transfer_function.h"

namespace isostrata {

/// JSON, where the name ends in .json: {"points": [{"value": 0.2, "color": "#ff8000", "opacity": 0.1}, ...]}, or that list alone.
/// Else a table with one colour a line, "R G B" or "R G B OPACITY" in [0, 1], separated by blanks or commas, at equal steps from
/// `lower` to `upper`; opacity is 0.3 if it does not stand there; thinned out to within 1/255.
/// Throws not_found, bad_data naming the file and the line or point, too_large above 1 MiB.
std::vector<TransferPoint> read_transfer(const std::filesystem::path& path, double lower, double upper);

}  // namespace isostrata
