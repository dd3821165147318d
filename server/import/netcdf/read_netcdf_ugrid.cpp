#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "import/netcdf/cf_axes.h"
#include "import/netcdf/netcdf_axes.h"
#include "import/netcdf/netcdf_placed.h"
#include "import/netcdf/netcdf_prisms.h"
#include "import/netcdf/netcdf_ugrid.h"
#include "import/netcdf/netcdf_values.h"
#include "import/vtk/vtk_blocks.h"

namespace isostrata {
namespace {

constexpr double kHalfTurn = 180;  // longitudes of one face that are farther apart lie on two sides of the date line

struct Mesh {
  int variable = 0, faces = 0, nodes = 0;  // dimensions
  std::array<int, 2> places{};             // variables
  int corners = 0;                         // the variable of each face's nodes
  bool faces_last = false;                 // it is over (corners, faces)
};

/// A variable on the mesh.
struct OnMesh {
  int variable = 0;
  bool on_faces = true;
  std::optional<int> time, level;
};

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> out;
  for (std::string word; in >> word;) out.push_back(word);
  return out;
}

class Reader {
 public:
  Reader(const NetcdfFile& file, const ReadRequest& request) : file_(file), request_(request), name_(request.file.filename().string()) {}

  std::optional<Imported> read() {
    if (!find_mesh()) return std::nullopt;
    const std::vector<OnMesh> all = variables();
    const OnMesh best = best_of(all);
    const NetcdfSteps steps = netcdf_steps(file_, best.time ? std::vector{*best.time} : std::vector<int>{}, name_);
    Imported imported;
    if (!steps.times.empty()) imported.times = steps.times;
    check_step(request_, imported.times.size());
    if (request_.times_only) return imported;

    const std::size_t levels = best.level ? file_.length(*best.level) : 1;
    std::vector<double> heights{0};
    if (best.level) heights = level_places(*best.level, imported);
    const Prisms prisms = prisms_of(outlines(), best.on_faces ? ends_of_levels(heights) : heights, request_);
    std::uint64_t bytes = 0;
    int read = 0;
    for (const OnMesh& of : all) {
      if (of.level != best.level || (of.time && of.time != best.time) || (best.level && levels > 1 && of.on_faces != best.on_faces)) continue;
      add(of, levels, steps, prisms, bytes);
      ++read;
    }
    append_vtk_blocks(prisms.grid, request_, false, imported.blocks, imported.notes);
    for (std::size_t a = 0; a < 2; ++a) imported.axes[a] = cf_meaning(axis_of(mesh_.places[a]));
    if (prisms.left_out > 0) imported.notes.push_back(std::to_string(prisms.left_out) + " cells skipped: they do not have 3 to 6 corners, or lie on both sides of the date line");
    if (const int others = static_cast<int>(std::ssize(all)) - read; others > 0) imported.notes.push_back(std::to_string(others) + " variables over other axes skipped");
    if (!steps.sorted) imported.notes.push_back(kTimesWereSorted);
    if (!steps.units.empty()) imported.notes.push_back("times are in " + steps.units);
    return imported;
  }

 private:
  CfAxis axis_of(int variable) const {
    return cf_axis(file_.name(variable), [&](const char* attribute) { return file_.text(variable, attribute); });
  }

  bool find_mesh() {
    bool any = false;
    for (int variable = 0; variable < file_.variables(); ++variable) {
      if (file_.text(variable, "cf_role") != "mesh_topology") continue;
      any = true;
      const auto corners = file_.variable(file_.text(variable, "face_node_connectivity"));
      const std::vector<std::string> named = words_of(file_.text(variable, "node_coordinates"));
      if (!corners || named.size() < 2) continue;
      const auto x = file_.variable(named[0]), y = file_.variable(named[1]);
      const std::vector<int> over = file_.dimensions(*corners);
      if (!x || !y || over.size() != 2 || file_.dimensions(*x).size() != 1 || file_.dimensions(*x) != file_.dimensions(*y)) continue;
      const std::string faces = file_.text(variable, "face_dimension");
      mesh_ = {variable, over[0], file_.dimensions(*x).front(), {*x, *y}, *corners, false};
      mesh_.faces_last = faces.empty() ? file_.length(over[0]) < file_.length(over[1]) && file_.length(over[0]) <= 8 : file_.dimension_name(over[1]) == faces;
      if (mesh_.faces_last) mesh_.faces = over[1];
      if (is_latitude(*x)) std::swap(mesh_.places[0], mesh_.places[1]);
      return true;
    }
    if (any) throw Error(ErrorCode::unsupported, name_ + ": netCDF with a mesh by the UGRID convention that has no faces; save it as .vtu, VTKHDF or CGNS (ParaView: Save Data)");
    return false;
  }
  bool is_latitude(int variable) const { return file_.text(variable, "standard_name") == "latitude" || file_.text(variable, "units").starts_with("degrees_n"); }

  std::vector<OnMesh> variables() const {
    const std::string mesh = file_.name(mesh_.variable);
    std::vector<OnMesh> out;
    for (int variable = 0; variable < file_.variables(); ++variable) {
      const std::string at = file_.text(variable, "location");
      if (!file_.type(variable) || file_.text(variable, "mesh") != mesh || (at != "face" && at != "node")) continue;
      OnMesh of{variable, at == "face", {}, {}};
      const int places = of.on_faces ? mesh_.faces : mesh_.nodes;
      const std::vector<int> over = file_.dimensions(variable);
      bool known = std::count(over.begin(), over.end(), places) == 1;
      for (const int dimension : over) {
        if (dimension == places) continue;
        if (!of.time && is_netcdf_time(file_, dimension))
          of.time = dimension;
        else if (!of.level)
          of.level = dimension;
        else
          known = false;
      }
      if (known) out.push_back(of);
    }
    if (out.empty()) throw Error(ErrorCode::unsupported, name_ + ": netCDF with a mesh by the UGRID convention ('" + mesh + "'), and no variable on its faces or nodes");
    return out;
  }

  /// One of those over the most levels, of which the most are; with a time, if there is one.
  OnMesh best_of(const std::vector<OnMesh>& all) const {
    const auto order = [&](const OnMesh& of) {
      const auto same = std::count_if(all.begin(), all.end(), [&](const OnMesh& other) { return other.level == of.level && other.on_faces == of.on_faces; });
      return std::tuple(of.level ? file_.length(*of.level) : 1, same, of.time.has_value(), -of.variable);
    };
    return *std::max_element(all.begin(), all.end(), [&](const OnMesh& a, const OnMesh& b) { return order(a) < order(b); });
  }

  /// By the level's own variable, or another one over it alone that says that it is upright.
  std::vector<double> level_places(int level, Imported& imported) const {
    std::optional<int> of;
    if (const auto own = file_.coordinate(level); own && own->group.number() == file_.number()) of = own->variable;
    for (int variable = 0; !of && variable < file_.variables(); ++variable) {
      const CfAxis says = axis_of(variable);
      if (file_.dimensions(variable) == std::vector{level} && file_.type(variable) && (!says.positive.empty() || says.axis == "Z" || !file_.text(variable, "formula_terms").empty())) of = variable;
    }
    const CfAxis axis = of ? axis_of(*of) : CfAxis{file_.dimension_name(level)};
    imported.axes[2] = cf_meaning(axis);
    return cf_places(of ? file_.values(*of) : std::vector<double>{}, file_.length(level), axis, imported.notes);
  }

  Outlines outlines() const {
    Outlines out;
    const std::vector<double> x = file_.values(mesh_.places[0]), y = file_.values(mesh_.places[1]);
    const std::size_t nodes = file_.length(mesh_.nodes), faces = file_.length(mesh_.faces);
    if (x.size() != nodes || y.size() != nodes) throw Error(ErrorCode::bad_data, name_ + ": the places of the nodes cannot be read");
    for (std::size_t n = 0; n < nodes; ++n) {
      if (!std::isfinite(x[n]) || !std::isfinite(y[n])) throw Error(ErrorCode::bad_data, name_ + ": node " + std::to_string(n) + " has no finite place");
      out.points.push_back({x[n], y[n]});
    }
    const std::vector<double> corners = file_.values(mesh_.corners);
    const std::size_t width = faces == 0 ? 0 : corners.size() / faces;
    if (faces == 0 || width * faces != corners.size()) throw Error(ErrorCode::bad_data, name_ + ": '" + file_.name(mesh_.corners) + "' has no faces");
    const std::vector<double> start = file_.numbers(mesh_.corners, "start_index");
    const double first = start.empty() ? 0 : start.front();
    const bool degrees = file_.text(mesh_.places[0], "units").starts_with("degree");
    for (std::size_t f = 0; f < faces; ++f) {
      std::vector<std::int64_t>& around = out.of_cells.emplace_back();
      double west = 1e300, east = -1e300;
      for (std::size_t c = 0; c < width; ++c) {
        const double said = corners[mesh_.faces_last ? c * faces + f : f * width + c] - first;
        if (!(said >= 0)) continue;  // no corner: a value for none, below the first
        if (said >= static_cast<double>(nodes)) {
          if (said >= 999'999) continue;  // a value for none that the file does not name
          throw Error(ErrorCode::bad_data, name_ + ": face " + std::to_string(f) + " has node " + std::to_string(static_cast<std::int64_t>(said + first)) + "; there are " + std::to_string(nodes));
        }
        const auto node = static_cast<std::int64_t>(said);
        west = std::min(west, x[static_cast<std::size_t>(node)]);
        east = std::max(east, x[static_cast<std::size_t>(node)]);
        if (std::find(around.begin(), around.end(), node) == around.end()) around.push_back(node);
      }
      if (degrees && east - west > kHalfTurn) around.clear();
    }
    return out;
  }

  void add(const OnMesh& of, std::size_t levels, const NetcdfSteps& steps, const Prisms& prisms, std::uint64_t& bytes) const {
    const int place = of.on_faces ? mesh_.faces : mesh_.nodes;
    const std::size_t places = file_.length(place);
    std::vector<std::size_t> from, count;
    bool places_first = false, seen_level = false;
    for (const int dimension : file_.dimensions(of.variable)) {
      from.push_back(of.time == dimension ? steps.index.at(dimension).at(static_cast<std::size_t>(request_.step)) : 0);
      count.push_back(of.time == dimension ? 1 : file_.length(dimension));
      seen_level = seen_level || of.level == dimension;
      if (dimension == place) places_first = !seen_level;
    }
    check_bytes(request_, bytes += places * levels * size_of(*file_.type(of.variable)), name_);
    const vtkSmartPointer<vtkDataArray> values = netcdf_values(file_, of.variable, from, count);
    std::vector<std::pair<std::size_t, std::size_t>> which = prisms.kept;
    if (!of.on_faces) {
      which.clear();
      for (std::size_t k = 0; k < levels; ++k)
        for (std::size_t n = 0; n < places; ++n) which.emplace_back(k, n);
    }
    const auto own = taken(*values, which, levels, places, places_first);
    own->SetName(file_.name(of.variable).c_str());
    if (const std::string unit = file_.text(of.variable, "units"); !unit.empty()) own->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), unit);
    of.on_faces ? prisms.grid->GetCellData()->AddArray(own) : prisms.grid->GetPointData()->AddArray(own);
  }

  const NetcdfFile& file_;
  const ReadRequest& request_;
  std::string name_;
  Mesh mesh_;
};

}  // namespace

std::optional<Imported> read_netcdf_ugrid(const NetcdfFile& file, const ReadRequest& request) { return Reader(file, request).read(); }

}  // namespace isostrata
