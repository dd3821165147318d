// What VTK's readers of EnSight do not check.
#pragma once

#include <filesystem>

namespace isostrata {

/// Throws bad_data or too_large if a case is none, names a file outside its folder or a set of times that it lacks, or declares more steps than it can
/// have; if its geometry is none; and if values are of a part without points, which VTK follows to nowhere. Parts of binary geometries, and of
/// files above 256 MB together, which take a while to look through, are left to VTK.
void check_ensight_case(const std::filesystem::path& file);

}  // namespace isostrata
