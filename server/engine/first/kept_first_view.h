// First views that are kept beside the imports they were made of, so that the second opening makes none.
#pragma once

#include <optional>

#include "data/dataset/dataset.h"
#include "engine/first/first_view.h"

namespace isostrata {

/// What keep_first_view kept for this very first step: of the same dataset, read by the same reader, by a program of the same version. Nothing if there is
/// none, or the dataset was not imported into the cache (import_cache.h).
std::optional<FirstView> kept_first_view(const Dataset& first_step);

/// Keeps it, if the dataset has a place for facts (kept_facts.h).
void keep_first_view(const Dataset& first_step, const FirstView& view);

}  // namespace isostrata
