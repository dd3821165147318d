// What the netCDF library does not check.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace isostrata {

/// A file of netCDF's classic formats (CDF-1, CDF-2, CDF-5) that ends early is read as if zeros followed. Throws bad_data if a variable lies beyond the file's
/// end, or the header does not parse. Other files pass.
void check_netcdf_classic(std::span<const std::byte> file, const std::string& name);

}  // namespace isostrata
