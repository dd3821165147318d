// Folders that are a plotfile of AMReX or BoxLib.
#pragma once

#include <filesystem>

namespace isostrata {

/// Whether the folder is one: its file Header begins with a version ("HyperCLaw-V1.1") and a number of components, and there is a folder Level_0 beside it.
bool is_plotfile(const std::filesystem::path& folder);

}  // namespace isostrata
