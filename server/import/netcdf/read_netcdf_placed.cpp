#include "import/netcdf/netcdf_placed.h"

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "import/netcdf/cf_axes.h"
#include "import/netcdf/netcdf_axes.h"
#include "import/netcdf/netcdf_values.h"

namespace isostrata {
namespace {

constexpr int kDeepestTerms = 8;
constexpr std::size_t kMostVariables = 10'000;

struct Placed {
  NetcdfVariable of;
  CfField over;
};

std::optional<Placed> placed(const NetcdfVariable& of) {
  if (!of.type()) return std::nullopt;
  const auto over = cf_field(of.group.dimensions(of.variable), [&](int dimension) { return of.group.length(dimension); }, [&](int dimension) { return is_netcdf_time(of.group, dimension); });
  return over ? std::optional(Placed{of, *over}) : std::nullopt;
}

void collect(const NetcdfGroup& group, int depth, std::vector<Placed>& out) {
  for (int variable = 0; variable < group.variables() && out.size() < kMostVariables; ++variable)
    if (auto one = placed({group, variable})) out.push_back(std::move(*one));
  if (depth < kDeepestTerms)
    for (const NetcdfGroup& inner : group.groups()) collect(inner, depth + 1, out);
}

std::vector<Placed> best_of(const std::vector<Placed>& all) {
  std::vector<CfField> fields;
  for (const Placed& one : all) fields.push_back(one.over);
  std::vector<Placed> out;
  for (const std::size_t f : best_cf_fields(fields)) out.push_back(all[f]);
  return out;
}

/// Whether it lies on straight axes.
bool place(Imported& imported, const Placed& of, const CfMoment& moment) {
  Block& block = imported.blocks.emplace_back();
  if (const auto curved = place_netcdf_on_curves(block, of.of, of.over.space, moment, imported.notes)) {
    imported.axes = *curved;
    return false;
  }
  imported.axes = netcdf_meaning(of.of.group, of.over.space);
  std::array<std::vector<double>, 3> axes{{{0}, {0}, {0}}};
  for (std::size_t axis = 0; axis < of.over.space.size(); ++axis) {
    const int dimension = of.over.space[of.over.space.size() - 1 - axis];
    const std::optional<NetcdfVariable> coordinate = of.of.group.coordinate(dimension);
    axes[axis] = cf_places(coordinate && coordinate->type() ? coordinate->values() : std::vector<double>{}, of.of.group.length(dimension), netcdf_axis(of.of.group, dimension), imported.notes);
  }
  place_on_axes(block, std::move(axes));
  return true;
}

FileArray array_of(const Placed& of, const NetcdfSteps& steps, int step) {
  std::vector<std::size_t> from, count;
  for (const int dimension : of.over.dimensions) {
    const bool space = std::find(of.over.space.begin(), of.over.space.end(), dimension) != of.over.space.end();
    from.push_back(of.over.time == dimension ? steps.index.at(dimension).at(static_cast<std::size_t>(step)) : 0);
    count.push_back(space ? of.of.group.length(dimension) : 1);
  }
  const vtkSmartPointer<vtkDataArray> values = netcdf_values(of.of.group, of.of.variable, from, count);
  FileArray array;
  array.name = of.of.group.prefix() + of.of.name();
  array.unit = of.of.text("units");
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
    for (const int dimension : of.over.space) points *= of.of.group.length(dimension);
    check_bytes(request, bytes += points * size_of(*of.of.type()), name);
    block.arrays.push_back(array_of(of, steps, request.step));
    request.progress(static_cast<double>(block.arrays.size()) / static_cast<double>(variables.size()));
  }
}

}  // namespace

std::size_t netcdf_axes_in_groups(const NetcdfFile& file) {
  std::vector<Placed> all;
  for (const NetcdfGroup& group : file.groups()) collect(group, 1, all);
  const std::vector<Placed> best = best_of(all);
  return best.empty() ? 0 : best.front().over.space.size();
}

bool is_netcdf_time(const NetcdfGroup& group, int dimension) {
  return is_cf_time(netcdf_axis(group, dimension));
}

std::optional<Imported> read_netcdf_placed(const NetcdfFile& file, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::vector<Placed> all;
  collect(file, 0, all);
  const std::vector<Placed> variables = best_of(all);
  if (variables.empty()) return std::nullopt;
  std::vector<int> timed;
  for (const Placed& of : variables)
    if (of.over.time && std::find(timed.begin(), timed.end(), *of.over.time) == timed.end()) timed.push_back(*of.over.time);
  const NetcdfGroup& group = variables.front().of.group;
  const NetcdfSteps steps = netcdf_steps(group, timed, name);
  Imported imported;
  if (!timed.empty()) imported.times = steps.times;
  check_step(request, imported.times.size());
  if (request.times_only) return imported;
  const auto says = std::find_if(variables.begin(), variables.end(), [](const Placed& of) { return !of.of.text("coordinates").empty(); });
  const Placed& first = says == variables.end() ? variables.front() : *says;
  CfMoment moment{first.over.time};
  if (moment.dimension) moment.place = steps.index.at(*moment.dimension).at(static_cast<std::size_t>(request.step));
  const bool straight = place(imported, first, moment);
  add_arrays(variables, steps, request, imported);
  if (const auto from = straight ? netcdf_turned(group, variables.front().over.space) : std::nullopt) turn_block(imported.blocks.front(), *from);
  if (const std::size_t others = all.size() - variables.size(); others > 0) imported.notes.push_back(std::to_string(others) + " variables over other axes skipped");
  if (!steps.sorted) imported.notes.push_back(kTimesWereSorted);
  if (!steps.units.empty()) imported.notes.push_back("times are in " + steps.units);
  return imported;
}

}  // namespace isostrata
