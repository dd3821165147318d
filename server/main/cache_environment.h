// Where what was read from files is kept between runs.
#pragma once

#include <optional>

#include "data/open/import_cache.h"

namespace isostrata {

/// $ISOSTRATA_CACHE is a folder, or "off"; by default $XDG_CACHE_HOME/isostrata, else ~/.cache/isostrata, and none if neither is known.
/// $ISOSTRATA_CACHE_SIZE is how much it may hold ("8GB"; suffixes KB, MB, GB). Throws invalid_argument if one of them makes no sense.
std::optional<ImportCache> import_cache_of_environment();

}  // namespace isostrata
