// The time that a VTK file says it has, from its beginning, without reading the rest.
#pragma once

#include <filesystem>
#include <optional>

namespace isostrata {

/// From the field array TimeValue or TIME in the first 64 KiB of an XML file (its text; the value if it is appended; else its range) or of a legacy file.
/// Nothing if there is none, or it is not one finite number.
std::optional<double> declared_time(const std::filesystem::path& file);

}  // namespace isostrata
