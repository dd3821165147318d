// The child's half of the door: the manifest and the raw files that import_door.h describes.
#pragma once

#include <filesystem>

#include "import/imported/imported.h"

namespace isostrata {

/// Appends blocks, averages cell arrays, splits vectors into magnitude and components, writes everything to `directory`.
/// Throws too_large, unavailable (the directory cannot be written).
void write_dataset(Imported imported, const ReadRequest& request, const std::filesystem::path& directory);

}  // namespace isostrata
