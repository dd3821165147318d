// netCDF variables that VTK's reader does not take: those in groups, those with time behind other axes or with axes of one place beside it, and those
// along axes whose places are packed or named.
#pragma once

#include <cstddef>
#include <optional>

#include "import/imported/imported.h"
#include "import/netcdf/netcdf_file.h"

namespace isostrata {

/// The variables over the most axes of space, in any group, at a step along their axis of time, wherever that stands; four axes of which none is time have their first as steps.
/// Places are those of the coordinate variables. Nothing if no variable has two or three axes of space.
std::optional<Imported> read_netcdf_placed(const NetcdfFile& file, const ReadRequest& request);

/// Over how many axes of space the best variables in groups are; 0 if there are none.
std::size_t netcdf_axes_in_groups(const NetcdfFile& file);

/// Whether a dimension's coordinate says that it is time.
bool is_netcdf_time(const NetcdfGroup& group, int dimension);

}  // namespace isostrata
