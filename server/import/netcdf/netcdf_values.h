// The values of netCDF variables, as they are meant.
#pragma once

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <vector>

#include "import/netcdf/netcdf_file.h"

namespace isostrata {

/// `count` values of a variable along each of its axes: scaled as it says, and NaN if it has none, which makes real numbers of whole ones. Throws bad_data.
vtkSmartPointer<vtkDataArray> netcdf_values(const NetcdfGroup& file, int variable, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count);

/// What such values are stored as.
ScalarType netcdf_stored(vtkDataArray& values);

}  // namespace isostrata
