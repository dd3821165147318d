// What the axes of variables mean by the conventions of climate and forecast (CF), whatever holds them: netCDF, or a group of Zarr.
//
// "NetCDF Climate and Forecast (CF) Metadata Conventions", cfconventions.org, sections 4 and 5.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "import/imported/imported.h"

namespace isostrata {

/// What a coordinate variable says of itself; of a dimension without one there is the name alone.
struct CfAxis {
  std::string name;
  bool has_places = false;
  std::string axis, units, positive, standard_name, calendar;
};

/// Of a coordinate variable that has these attributes.
CfAxis cf_axis(const std::string& name, const std::function<std::string(const char* attribute)>& text);
/// What it is to whoever looks at it.
Axis cf_meaning(const CfAxis& axis);
bool is_cf_time(const CfAxis& axis);

/// The units of times, with the calendar: what day it is depends on it, models have years of 365 and of 360 days.
std::string cf_time_units(const CfAxis& axis);

/// The places along an axis of time, in the order of their times.
struct CfSteps {
  std::vector<double> times;
  std::vector<std::size_t> order;
  bool sorted = true;  // they were in this order
};
CfSteps cf_steps(const std::vector<double>& along);
inline constexpr const char* kTimesWereSorted = "the file's times do not increase: its steps are in the order of their times";

/// A variable over dimensions, by their numbers, and what these are.
struct CfField {
  std::vector<int> dimensions;  // all
  std::vector<int> space;       // of these two or three, of more than one place, x usually last
  std::optional<int> time;
  std::size_t values = 1;
};

/// Nothing if it is not over two or three axes of space. Of four axes of which none is time the first counts steps.
std::optional<CfField> cf_field(const std::vector<int>& dimensions, const std::function<std::size_t(int)>& length, const std::function<bool(int)>& is_time);

/// Which of them are over the same axes of space as the best: over the most, with a time, of the most values; then the most variables, then the first. Empty if there are none.
std::vector<std::size_t> best_cf_fields(std::span<const CfField> all);

/// Which axis of a block over these (0: the last of them) is x, which y and which z; nothing if they do not say, or where the order is this one. Two or three.
std::optional<std::array<std::size_t, 3>> cf_turned(const std::vector<CfAxis>& axes);

/// What x, y and z are, of two or three of these in the same order.
Axes cf_axes(const std::vector<CfAxis>& axes);

/// The places that a coordinate variable has, upwards if they are depths; counted from 0 if these are not `length` numbers that go one way, which a note says.
std::vector<double> cf_places(std::vector<double> own, std::size_t length, const CfAxis& axis, std::vector<std::string>& notes);

/// Gives the block the points of three axes, each of at least one place: a uniform grid if they are even to a thousandth, as VTK's reader of netCDF has it, else a rectilinear one.
void place_on_axes(Block& block, std::array<std::vector<double>, 3> axes);

}  // namespace isostrata
