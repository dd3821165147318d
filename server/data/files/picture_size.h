// How large the picture in a file is, from the file's first bytes.
#pragma once

#include <filesystem>
#include <optional>
#include <utility>

namespace isostrata {

/// Columns and rows of a PNG, BMP, PGM, PNM or TIFF file (of its first page); nothing if the file does not say. Reads at most 64 KiB.
std::optional<std::pair<int, int>> picture_size(const std::filesystem::path& file);

}  // namespace isostrata
