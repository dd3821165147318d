#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "import/netcdf/cf_axes.h"
#include "import/netcdf/netcdf_axes.h"
#include "import/netcdf/netcdf_cells.h"
#include "import/netcdf/netcdf_placed.h"
#include "import/netcdf/netcdf_prisms.h"
#include "import/netcdf/netcdf_values.h"
#include "import/vtk/vtk_blocks.h"

namespace isostrata {
namespace {

/// A variable over cells: its last axis.
struct OverCells {
  int variable = 0, longitude = 0, latitude = 0, cells = 0;
  std::optional<int> time, level;
};

std::optional<OverCells> over_cells(const NetcdfFile& file, int variable) {
  const std::vector<int> dimensions = file.dimensions(variable);
  if (!file.type(variable) || dimensions.empty() || dimensions.size() > 3) return std::nullopt;
  OverCells out{.variable = variable, .longitude = -1, .latitude = -1, .cells = dimensions.back()};
  std::istringstream names(file.text(variable, "coordinates"));
  for (std::string name; names >> name;) {
    const auto of = file.variable(name);
    if (!of || file.dimensions(*of) != std::vector{out.cells}) continue;
    if (file.text(*of, "standard_name") == "longitude") out.longitude = *of;
    if (file.text(*of, "standard_name") == "latitude") out.latitude = *of;
  }
  if (out.longitude < 0 || out.latitude < 0) return std::nullopt;
  for (const int dimension : std::vector(dimensions.begin(), dimensions.end() - 1))
    if (!out.time && is_netcdf_time(file, dimension))
      out.time = dimension;
    else if (!out.level)
      out.level = dimension;
    else
      return std::nullopt;
  return out;
}

/// [cells][corners], in degrees; empty if there are none.
std::vector<double> corners_along(const NetcdfFile& file, int coordinate, std::size_t cells) {
  const auto bounds = file.variable(file.text(coordinate, "bounds"));
  if (!bounds || file.dimensions(*bounds).size() != 2 || file.length(file.dimensions(*bounds).front()) != cells) return {};
  std::vector<double> out = NetcdfVariable{file, *bounds}.values();
  const bool radians = file.text(coordinate, "units").starts_with("rad");
  for (double& x : out) x *= radians ? 180 / std::numbers::pi : 1;
  return out;
}

/// Corners are one point if they are less than a millionth of a degree apart.
Outlines outlines(const std::vector<double>& longitudes, const std::vector<double>& latitudes, std::size_t cells) {
  Outlines out;
  const std::size_t corners = longitudes.size() / cells;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> known;
  for (std::size_t c = 0; c < cells; ++c) {
    std::vector<std::int64_t>& around = out.of_cells.emplace_back();
    for (std::size_t v = c * corners; v < (c + 1) * corners; ++v) {
      if (!std::isfinite(longitudes[v]) || !(std::abs(longitudes[v]) < 1e6) || !(std::abs(latitudes[v]) < 1e6)) continue;
      const double first = longitudes[c * corners], longitude = longitudes[v] - 360 * std::round((longitudes[v] - first) / 360);  // on the first one's side of the date line
      const auto [at, fresh] = known.try_emplace({std::llround(1e6 * longitude), std::llround(1e6 * latitudes[v])}, std::ssize(out.points));
      if (fresh) out.points.push_back({longitude, latitudes[v]});
      if (std::find(around.begin(), around.end(), at->second) == around.end()) around.push_back(at->second);
    }
  }
  return out;
}

}  // namespace

std::optional<Imported> read_netcdf_cells(const NetcdfFile& file, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::vector<OverCells> all;
  for (int variable = 0; variable < file.variables(); ++variable)
    if (const auto one = over_cells(file, variable)) all.push_back(*one);
  if (all.empty()) return std::nullopt;
  const auto levels_of = [&](const OverCells& of) { return of.level ? file.length(*of.level) : 1; };
  const OverCells first = *std::max_element(all.begin(), all.end(), [&](const OverCells& a, const OverCells& b) { return levels_of(a) < levels_of(b); });
  const std::size_t cells = file.length(first.cells), levels = levels_of(first);
  const std::vector<double> longitudes = corners_along(file, first.longitude, cells), latitudes = corners_along(file, first.latitude, cells);
  if (longitudes.empty() || longitudes.size() != latitudes.size()) {
    if (file.text(first.variable, "CDI_grid_type") != "unstructured") return std::nullopt;
    throw Error(ErrorCode::unsupported, name + ": the cells of '" + file.name(first.variable) + "' say no corners (bounds of '" + file.name(first.longitude) + "'); put it on longitudes and latitudes: cdo remapnn,r360x180 IN OUT");
  }
  const NetcdfSteps steps = netcdf_steps(file, first.time ? std::vector{*first.time} : std::vector<int>{}, name);
  Imported imported;
  if (!steps.times.empty()) imported.times = steps.times;
  check_step(request, imported.times.size());
  if (request.times_only) return imported;

  const Outlines around = outlines(longitudes, latitudes, cells);
  const std::optional<NetcdfVariable> coordinate = first.level ? file.coordinate(*first.level) : std::nullopt;
  std::vector<double> at{0};
  if (first.level) at = cf_places(coordinate && coordinate->type() ? coordinate->values() : std::vector<double>{}, levels, netcdf_axis(file, *first.level), imported.notes);
  const Prisms prisms = prisms_of(around, ends_of_levels(at), request);
  std::uint64_t bytes = 0;
  for (const OverCells& of : all) {
    if (of.cells != first.cells || of.level != first.level || (of.time && of.time != first.time)) continue;
    std::vector<std::size_t> from, count;
    for (const int dimension : file.dimensions(of.variable)) {
      from.push_back(of.time == dimension ? steps.index.at(dimension).at(static_cast<std::size_t>(request.step)) : 0);
      count.push_back(of.time == dimension ? 1 : file.length(dimension));
    }
    check_bytes(request, bytes += cells * levels * size_of(*file.type(of.variable)), name);
    const vtkSmartPointer<vtkDataArray> values = netcdf_values(file, of.variable, from, count);
    const auto own = taken(*values, prisms.kept, levels, cells, false);
    own->SetName(file.name(of.variable).c_str());
    prisms.grid->GetCellData()->AddArray(own);
    if (const std::string unit = file.text(of.variable, "units"); !unit.empty()) own->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), unit);
  }
  imported.axes = {Axis{"longitude", "degrees_east"}, Axis{"latitude", "degrees_north"}, first.level ? cf_meaning(netcdf_axis(file, *first.level)) : Axis{}};
  append_vtk_blocks(prisms.grid, request, false, imported.blocks, imported.notes);
  if (prisms.left_out > 0) imported.notes.push_back(std::to_string(prisms.left_out) + " cells skipped: they do not have 3 to 6 corners");
  if (const int others = static_cast<int>(std::ssize(all)) - prisms.grid->GetCellData()->GetNumberOfArrays(); others > 0) imported.notes.push_back(std::to_string(others) + " variables over other axes skipped");
  imported.notes.emplace_back("cells lie at their longitudes and latitudes, in degrees" + std::string(levels == 1 ? "" : ", each level up to the middles between it and its neighbours"));
  if (!steps.sorted) imported.notes.push_back(kTimesWereSorted);
  if (!steps.units.empty()) imported.notes.push_back("times are in " + steps.units);
  return imported;
}

}  // namespace isostrata
