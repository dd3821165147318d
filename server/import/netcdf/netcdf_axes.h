// What the axes of netCDF variables mean.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "import/imported/imported.h"
#include "import/netcdf/cf_axes.h"
#include "import/netcdf/cf_curved.h"
#include "import/netcdf/netcdf_file.h"

namespace isostrata {

/// The steps along dimensions of time, in the order of their times.
struct NetcdfSteps {
  std::vector<double> times;
  std::map<int, std::vector<std::size_t>> index;  // by dimension, for each step: where along it
  bool sorted = true;                             // the file has them in this order
  std::string units;
};

/// Of one dimension all steps, those of a time twice as well; of several the times that any of them has. Throws bad_data if a time is not a finite number.
NetcdfSteps netcdf_steps(const NetcdfGroup& file, const std::vector<int>& dimensions, const std::string& name);

/// What the coordinate of a dimension says of itself.
CfAxis netcdf_axis(const NetcdfGroup& file, int dimension);

/// Which axis of a block over these dimensions (0: the last of them) is x, which y and which z; nothing if they do not say, or where the order is this one.
std::optional<std::array<std::size_t, 3>> netcdf_turned(const NetcdfGroup& file, const std::vector<int>& dimensions);

/// What x, y and z are over these dimensions (x usually last).
Axes netcdf_meaning(const NetcdfGroup& file, const std::vector<int>& dimensions);

/// As place_on_curves, for the variable at a step.
std::optional<Axes> place_netcdf_on_curves(Block& block, const NetcdfVariable& of, const std::vector<int>& space, const CfMoment& moment, std::vector<std::string>& notes);

/// Turns the axes of a block, and its arrays: new axis a is the one that was from[a]. Only of straight axes and values on points.
void turn_block(Block& block, const std::array<std::size_t, 3>& from);

}  // namespace isostrata
