#include "import/netcdf_placed.h"

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "data/recognise.h"
#include "import/netcdf_axes.h"
#include "import/netcdf_values.h"
#include "import/read_own.h"

namespace isostrata {
namespace {

constexpr int kDeepest = 8;
constexpr std::size_t kMostVariables = 10'000;
constexpr double kEven = 1e-3;  // of a spacing, as VTK's reader has it

/// A variable and what its axes are.
struct Placed {
  NetcdfVariable of;
  std::vector<int> dimensions;  // all
  std::vector<int> space;       // of these two or three, of more than one place, x usually last
  std::optional<int> time;
  std::size_t values = 1;
};

std::optional<Placed> placed(const NetcdfVariable& of) {
  if (!of.type()) return std::nullopt;
  Placed out{of, of.group.dimensions(of.variable), {}, {}, 1};
  for (const int dimension : out.dimensions) {
    out.values *= std::max<std::size_t>(of.group.length(dimension), 1);
    if (!out.time && is_netcdf_time(of.group, dimension))
      out.time = dimension;
    else if (of.group.length(dimension) > 1)
      out.space.push_back(dimension);
  }
  if (!out.time && out.space.size() == 4) {
    out.time = out.space.front();
    out.space.erase(out.space.begin());
  }
  return out.space.size() == 2 || out.space.size() == 3 ? std::optional(out) : std::nullopt;
}

void collect(const NetcdfGroup& group, int depth, std::vector<Placed>& out) {
  for (int variable = 0; variable < group.variables() && out.size() < kMostVariables; ++variable)
    if (auto one = placed({group, variable})) out.push_back(std::move(*one));
  if (depth < kDeepest)
    for (const NetcdfGroup& inner : group.groups()) collect(inner, depth + 1, out);
}

/// Those over the same axes of space as the best: over the most, with a time, of the most values; then the most variables, then the first.
std::vector<Placed> best_of(const std::vector<Placed>& all) {
  std::map<std::vector<int>, std::vector<Placed>> groups;
  for (const Placed& one : all) groups[one.space].push_back(one);
  const auto order = [](const std::vector<Placed>& some) {
    const auto most = std::max_element(some.begin(), some.end(), [](const Placed& a, const Placed& b) { return a.values < b.values; });
    return std::tuple(some.front().space.size(), most->time.has_value(), most->values, some.size());
  };
  const auto best = std::max_element(groups.begin(), groups.end(), [&](const auto& a, const auto& b) { return order(a.second) < order(b.second); });
  return best == groups.end() ? std::vector<Placed>{} : best->second;
}

/// Where the points along a dimension are; counted from 0 where nothing says it, or what says it does not go one way.
std::vector<double> places_along(const NetcdfGroup& group, int dimension, std::vector<std::string>& notes) {
  std::vector<double> counted(group.length(dimension));
  std::iota(counted.begin(), counted.end(), 0.0);
  const std::optional<NetcdfVariable> coordinate = group.coordinate(dimension);
  if (!coordinate || !coordinate->type()) return counted;
  std::vector<double> places = coordinate->values();
  if (places.size() != counted.size()) return counted;  // names, say
  if (coordinate->text("positive") == "down")
    for (double& place : places) place = -place;
  const bool finite = std::all_of(places.begin(), places.end(), [](double place) { return std::isfinite(place); });
  const bool one_way = std::adjacent_find(places.begin(), places.end(), std::less_equal<>()) == places.end() || std::adjacent_find(places.begin(), places.end(), std::greater_equal<>()) == places.end();
  if (finite && one_way) return places;
  notes.push_back("'" + coordinate->name() + "' does not go one way: points along it are 1 apart");
  return counted;
}

bool even(const std::vector<double>& places) {
  const double spacing = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
  for (std::size_t i = 1; i < places.size(); ++i)
    if (std::abs(places[i] - places[i - 1] - spacing) > kEven * std::abs(spacing)) return false;
  return true;
}

void place(Block& block, const Placed& of, std::vector<std::string>& notes) {
  RectilinearGrid grid{{1, 1, 1}, {{{0}, {0}, {0}}}};
  for (std::size_t axis = 0; axis < of.space.size(); ++axis) {
    grid.axes[axis] = places_along(of.of.group, of.space[of.space.size() - 1 - axis], notes);
    grid.dims[axis] = static_cast<std::int64_t>(grid.axes[axis].size());
  }
  if (!std::all_of(grid.axes.begin(), grid.axes.begin() + static_cast<std::ptrdiff_t>(of.space.size()), even)) {
    block.grid.shape = std::move(grid);
    return;
  }
  UniformGrid uniform{grid.dims, {}, {1, 1, 1}};
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double>& places = grid.axes[static_cast<std::size_t>(axis)];
    uniform.origin[axis] = places.front();
    if (places.size() > 1) uniform.spacing[axis] = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
  }
  block.grid.shape = uniform;
}

FileArray array_of(const Placed& of, const NetcdfSteps& steps, int step) {
  std::vector<std::size_t> from, count;
  for (const int dimension : of.dimensions) {
    const bool space = std::find(of.space.begin(), of.space.end(), dimension) != of.space.end();
    from.push_back(of.time == dimension ? steps.index.at(dimension).at(static_cast<std::size_t>(step)) : 0);
    count.push_back(space ? of.of.group.length(dimension) : 1);
  }
  const vtkSmartPointer<vtkDataArray> values = netcdf_values(of.of.group, of.of.variable, from, count);
  FileArray array;
  array.name = of.of.group.prefix() + of.of.name();
  array.type = netcdf_stored(*values);
  array.values = {static_cast<const std::byte*>(values->GetVoidPointer(0)), static_cast<std::size_t>(values->GetNumberOfValues()) * size_of(array.type)};
  array.storage = std::make_shared<vtkSmartPointer<vtkDataArray>>(values);
  return array;
}

void add_arrays(const std::vector<Placed>& variables, const NetcdfSteps& steps, const ReadRequest& request, Imported& imported) {
  const std::string name = request.file.filename().string();
  Block& block = imported.blocks.front();
  std::uint64_t bytes = 0;
  for (const Placed& of : variables) {
    std::size_t points = 1;
    for (const int dimension : of.space) points *= of.of.group.length(dimension);
    check_bytes(request, bytes += points * size_of(*of.of.type()), name);
    block.arrays.push_back(array_of(of, steps, request.step));
    if (const std::string units = of.of.text("units"); !units.empty()) imported.notes.push_back("unit of '" + block.arrays.back().name + "': " + units);
    request.progress(static_cast<double>(block.arrays.size()) / static_cast<double>(variables.size()));
  }
}

}  // namespace

std::size_t netcdf_axes_in_groups(const NetcdfFile& file) {
  std::vector<Placed> all;
  for (const NetcdfGroup& group : file.groups()) collect(group, 1, all);
  const std::vector<Placed> best = best_of(all);
  return best.empty() ? 0 : best.front().space.size();
}

bool is_netcdf_time(const NetcdfGroup& group, int dimension) {
  const std::optional<NetcdfVariable> coordinate = group.coordinate(dimension);
  if (!coordinate) return small_letters(group.dimension_name(dimension)) == "time";
  return coordinate->text("axis") == "T" || coordinate->text("standard_name") == "time" || coordinate->text("units").find(" since ") != std::string::npos || small_letters(coordinate->name()) == "time";
}

std::optional<Imported> read_netcdf_placed(const NetcdfFile& file, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::vector<Placed> all;
  collect(file, 0, all);
  const std::vector<Placed> variables = best_of(all);
  if (variables.empty()) return std::nullopt;
  std::vector<int> timed;
  for (const Placed& of : variables)
    if (of.time && std::find(timed.begin(), timed.end(), *of.time) == timed.end()) timed.push_back(*of.time);
  const NetcdfGroup& group = variables.front().of.group;
  const NetcdfSteps steps = netcdf_steps(group, timed, name);
  Imported imported;
  if (!timed.empty()) imported.times = steps.times;
  check_step(request, imported.times.size());
  if (request.times_only) return imported;
  place(imported.blocks.emplace_back(), variables.front(), imported.notes);
  add_arrays(variables, steps, request, imported);
  if (const auto from = netcdf_turned(group, variables.front().space)) turn_block(imported.blocks.front(), *from);
  if (const std::size_t others = all.size() - variables.size(); others > 0) imported.notes.push_back(std::to_string(others) + " variables over other axes skipped");
  if (!steps.sorted) imported.notes.push_back("the file's times do not increase: its steps are in the order of their times");
  if (!steps.units.empty()) imported.notes.push_back("times are in " + steps.units);
  return imported;
}

}  // namespace isostrata
