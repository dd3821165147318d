// The files that a dataset is read from, and how they are now: what tells one reading of them from the next.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace isostrata {

/// A line for each file: path, bytes, time of the last change. Of a file that lists others, these too; of a format that may open what lies
/// beside it (OpenFOAM, XDMF's like, halves of a pair), all that lies beside it, two folders down; of a Zarr folder all that is in it. nullopt where
/// these are more than 10,000, or `file` is not there. Reads the beginnings of files only. Any thread.
std::optional<std::string> source_files(const std::filesystem::path& file);

}  // namespace isostrata
