#include "import/netcdf/cf_axes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <numeric>
#include <string_view>
#include <tuple>
#include <utility>

#include "data/files/recognise.h"

namespace isostrata {
namespace {

constexpr double kEven = 1e-3;  // of a spacing

std::optional<std::size_t> direction_by_name(const std::string& name) {
  const auto letter = static_cast<std::size_t>((name.empty() ? 0 : name.front() | 0x20) - 'x');
  return name.size() == 1 && letter < 3 ? std::optional(letter) : std::nullopt;
}

/// 0, 1 or 2 for an axis that says that it is x, y or z.
std::optional<std::size_t> direction(const CfAxis& of) {
  const auto is_one_of = [](const std::string& text, std::initializer_list<std::string_view> words) { return std::find(words.begin(), words.end(), text) != words.end(); };
  if (is_one_of(of.axis, {"X", "Y", "Z"})) return static_cast<std::size_t>(of.axis.front() - 'X');
  if (is_one_of(of.units, {"degrees_east", "degree_east", "degrees_E", "degree_E", "degreesE", "degreeE"})) return 0;
  if (is_one_of(of.units, {"degrees_north", "degree_north", "degrees_N", "degree_N", "degreesN", "degreeN"})) return 1;
  if (is_one_of(of.positive, {"up", "down"})) return 2;
  return direction_by_name(of.name);
}

bool even(const std::vector<double>& places) {
  const double spacing = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
  for (std::size_t i = 1; i < places.size(); ++i)
    if (std::abs(places[i] - places[i - 1] - spacing) > kEven * std::abs(spacing)) return false;
  return true;
}

/// Pressures fall upwards, though files need not say so (CF conventions, section 4.3.1).
bool is_pressure(const std::string& units) {
  const std::string small = small_letters(units);
  return small == "pa" || small == "hpa" || small == "kpa" || small == "mb" || small == "mbar" || small.starts_with("millibar") || small == "pascal" || small == "bar" || small == "dbar" || small == "decibar" || small == "decibars";
}

}  // namespace

CfAxis cf_axis(const std::string& name, const std::function<std::string(const char*)>& text) {
  CfAxis out{name, true, text("axis"), text("units"), text("positive"), text("standard_name"), text("calendar")};
  if (out.positive.empty() && is_pressure(out.units)) out.positive = "down";
  return out;
}

Axis cf_meaning(const CfAxis& of) {
  std::string name = of.standard_name.empty() ? of.name : of.standard_name;
  std::replace(name.begin(), name.end(), '_', ' ');
  return {name, of.units == "1" ? "" : of.units, of.positive == "down"};
}

Axes cf_axes(const std::vector<CfAxis>& axes) {
  Axes in_order;
  for (std::size_t a = 0; a < std::min<std::size_t>(axes.size(), 3); ++a) in_order[a] = cf_meaning(axes[axes.size() - 1 - a]);
  const auto from = cf_turned(axes);
  return from ? Axes{in_order[(*from)[0]], in_order[(*from)[1]], in_order[(*from)[2]]} : in_order;
}

bool is_cf_time(const CfAxis& of) {
  if (!of.has_places) return small_letters(of.name) == "time";
  return of.axis == "T" || of.standard_name == "time" || of.units.find(" since ") != std::string::npos || small_letters(of.name) == "time";
}

std::string cf_time_units(const CfAxis& axis) { return axis.units.empty() || axis.calendar.empty() ? axis.units : axis.units + ", calendar " + axis.calendar; }

CfSteps cf_steps(const std::vector<double>& along) {
  CfSteps steps{along, std::vector<std::size_t>(along.size()), std::is_sorted(along.begin(), along.end())};
  std::iota(steps.order.begin(), steps.order.end(), std::size_t{0});
  std::stable_sort(steps.order.begin(), steps.order.end(), [&](std::size_t a, std::size_t b) { return along[a] < along[b]; });
  std::sort(steps.times.begin(), steps.times.end());
  return steps;
}

std::optional<CfField> cf_field(const std::vector<int>& dimensions, const std::function<std::size_t(int)>& length, const std::function<bool(int)>& is_time) {
  CfField out{dimensions, {}, {}, 1};
  for (const int dimension : dimensions) {
    out.values *= std::max<std::size_t>(length(dimension), 1);
    if (!out.time && is_time(dimension))
      out.time = dimension;
    else if (length(dimension) > 1)
      out.space.push_back(dimension);
  }
  if (!out.time && out.space.size() == 4) {
    out.time = out.space.front();
    out.space.erase(out.space.begin());
  }
  return out.space.size() == 2 || out.space.size() == 3 ? std::optional(out) : std::nullopt;
}

std::vector<std::size_t> best_cf_fields(std::span<const CfField> all) {
  std::map<std::vector<int>, std::vector<std::size_t>> groups;
  for (std::size_t f = 0; f < all.size(); ++f) groups[all[f].space].push_back(f);
  const auto order = [&](const std::vector<std::size_t>& some) {
    const auto most = std::max_element(some.begin(), some.end(), [&](std::size_t a, std::size_t b) { return all[a].values < all[b].values; });
    return std::tuple(all[some.front()].space.size(), all[*most].time.has_value(), all[*most].values, some.size());
  };
  const auto best = std::max_element(groups.begin(), groups.end(), [&](const auto& a, const auto& b) { return order(a.second) < order(b.second); });
  return best == groups.end() ? std::vector<std::size_t>{} : best->second;
}

std::optional<std::array<std::size_t, 3>> cf_turned(const std::vector<CfAxis>& axes) {
  if (axes.size() == 2 && direction(axes[0]) == 0u && direction(axes[1]) == 1u) return std::array<std::size_t, 3>{1, 0, 2};
  if (axes.size() != 3) return std::nullopt;
  constexpr std::size_t kNone = 3;
  std::array<std::size_t, 3> of{kNone, kNone, kNone};
  std::size_t known = 0, sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::optional<std::size_t> along = direction(axes[2 - axis]);
    if (!along) continue;
    if (of[*along] != kNone) return std::nullopt;
    of[*along] = axis;
    sum += axis;
    ++known;
  }
  if (known < 2) return std::nullopt;
  std::replace(of.begin(), of.end(), kNone, 3 - sum);
  return of == std::array<std::size_t, 3>{0, 1, 2} ? std::nullopt : std::optional(of);
}

std::vector<double> cf_places(std::vector<double> own, std::size_t length, const CfAxis& axis, std::vector<std::string>& notes) {
  std::vector<double> counted(length);
  std::iota(counted.begin(), counted.end(), 0.0);
  if (own.size() != length) return counted;  // names, say
  if (axis.positive == "down")
    for (double& place : own) place = -place;
  const bool finite = std::all_of(own.begin(), own.end(), [](double place) { return std::isfinite(place); });
  const bool one_way = std::adjacent_find(own.begin(), own.end(), std::less_equal<>()) == own.end() || std::adjacent_find(own.begin(), own.end(), std::greater_equal<>()) == own.end();
  if (finite && one_way) return own;
  notes.push_back("'" + axis.name + "' does not go one way: points along it are 1 apart");
  return counted;
}

void place_on_axes(Block& block, std::array<std::vector<double>, 3> axes) {
  std::array<std::int64_t, 3> dims{};
  for (std::size_t a = 0; a < 3; ++a) dims[a] = static_cast<std::int64_t>(axes[a].size());
  if (!std::all_of(axes.begin(), axes.end(), [](const auto& places) { return places.size() < 2 || even(places); })) {
    block.grid.shape = RectilinearGrid{dims, std::move(axes)};
    return;
  }
  UniformGrid uniform{dims, {}, {1, 1, 1}};
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& places = axes[static_cast<std::size_t>(axis)];
    uniform.origin[axis] = places.front();
    if (places.size() > 1) uniform.spacing[axis] = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
  }
  block.grid.shape = uniform;
}

}  // namespace isostrata
