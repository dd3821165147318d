// netCDF whose cells lie anywhere on the globe and say their corners: ICON, GME, and what CDO calls unstructured.
//
// CF 1.8, sections 5 and 7.1: a variable's `coordinates` are a longitude and a latitude over one axis, whose `bounds` are the corners of each cell.
#pragma once

#include <optional>

#include "import/imported/imported.h"
#include "import/netcdf/netcdf_file.h"

namespace isostrata {

/// Areas in degrees, or layers of prisms between the middles of levels; values are the cells'. Nothing if the file's variables are not over such cells. Throws unsupported if they are over cells without corners.
std::optional<Imported> read_netcdf_cells(const NetcdfFile& file, const ReadRequest& request);

}  // namespace isostrata
