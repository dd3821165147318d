// The files that a file lists: pieces, parts, steps, the data of a header.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/files/recognise.h"

namespace isostrata {

/// Names as they stand in the file, relative to its folder; those of EnSight's and of MetaImage's steps are patterns with *. Reads at most 4 MiB. Only for a listing: a
/// reader parses its format properly.
std::vector<std::string> referred_names(const std::filesystem::path& file, const Recognised& of);

}  // namespace isostrata
