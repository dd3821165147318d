// Numbered files that are one thing in several resolutions ("etopo5.cdf", "etopo20.cdf") rather than steps.
#pragma once

#include <filesystem>
#include <span>

#include "data/files/look_at_folder.h"

namespace isostrata {

/// Whether these files of one kind, of one folder, have grids that differ as resolutions do: they are few, hold one structured grid each, no two of them are alike in size,
/// and none says the same number of points as another. Opens files only where their sizes leave it open.
bool are_several_resolutions(const std::filesystem::path& folder, std::span<const LookedAt* const> files);

}  // namespace isostrata
