// netCDF with a mesh by the UGRID convention: nodes, and faces that say their nodes; of oceans, coasts and rivers.
//
// UGRID 1.0, ugrid-conventions.github.io.
#pragma once

#include <optional>

#include "import/imported/imported.h"
#include "import/netcdf/netcdf_file.h"

namespace isostrata {

/// Faces as areas, or layers of prisms: of values on faces between the middles of levels, of values on nodes from level to level. Nothing if the file has no mesh. Throws unsupported if it
/// has one without faces, or without variables on it, bad_data for faces whose nodes are not there.
std::optional<Imported> read_netcdf_ugrid(const NetcdfFile& file, const ReadRequest& request);

}  // namespace isostrata
