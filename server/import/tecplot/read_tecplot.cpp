// The zones of a Tecplot file as blocks.
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>

#include "data/files/recognise.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/trimmed.h"
#include "import/imported/read_own.h"
#include "import/tecplot/tecplot_zone.h"
#include "import/vtk/set_cells.h"
#include "import/vtk/vtk_blocks.h"
#include "import/vtk/vtk_type.h"

namespace isostrata {

int tecplot_nodes(TecplotKind kind) {
  constexpr std::array kNodes{0, 2, 3, 4, 4, 8};
  return kNodes[static_cast<std::size_t>(kind)];
}

int TecplotZone::dimension() const {
  if (kind != TecplotKind::ordered) return kind == TecplotKind::line ? 1 : kind == TecplotKind::triangle || kind == TecplotKind::quadrilateral ? 2 : 3;
  return static_cast<int>(std::count_if(dims.begin(), dims.end(), [](std::int64_t size) { return size > 1; }));
}

void TecplotZone::set_ordered(const std::array<std::int64_t, 3>& size, const std::string& file) {
  dims = size;
  points = checked_product({size[0], size[1], size[2]}, file);
  cells = 1;
  for (const std::int64_t of : size) cells *= std::max<std::int64_t>(of - 1, 1);
}

namespace {

/// "Pressure [Pa]" and "p (Pa)" are a name and a unit.
struct Variable {
  std::string name, unit;
};

Variable variable_of(const std::string& said) {
  const std::string_view text = trimmed(said);
  for (const auto& [open, close] : {std::pair{'[', ']'}, {'(', ')'}}) {
    const std::size_t at = text.rfind(open);
    if (text.ends_with(close) && at != std::string_view::npos && at > 0)
      return {std::string(trimmed(text.substr(0, at))), std::string(trimmed(text.substr(at + 1, text.size() - at - 2)))};
  }
  return {std::string(text), {}};
}

/// Which variables are x, y and z: by their names, else the first ones; nothing for z of surfaces that have none.
std::array<std::optional<std::size_t>, 3> places_of(const std::vector<Variable>& variables, int dimension) {
  std::array<std::optional<std::size_t>, 3> out;
  for (std::size_t v = variables.size(); v-- > 0;) {
    std::string name = small_letters(variables[v].name);
    for (const char* more : {"coordinate", "coord", "-", "_", " "})
      if (const auto at = name.find(more); at != std::string::npos) name.erase(at, std::strlen(more));
    if (name.size() == 1 && name[0] >= 'x' && name[0] <= 'z') out[static_cast<std::size_t>(name[0] - 'x')] = v;
  }
  if (out[0] && out[1] && (out[2] || dimension < 3)) return out;
  out = {0, 1, std::nullopt};
  if (dimension == 3) out[2] = 2;
  return out;
}

class Zones {
 public:
  Zones(const ReadRequest& request, const MappedFile& mapped)
      : request_(request), name_(request.file.filename().string()), bytes_(mapped.bytes()), text_(reinterpret_cast<const char*>(bytes_.data()), bytes_.size()), binary_(text_.starts_with("#!TDV")) {}

  Imported read() {
    file_ = binary_ ? tecplot_binary(bytes_, name_) : tecplot_text(text_, name_);
    int dimension = 0;
    for (const TecplotZone& zone : file_.zones) dimension = std::max(dimension, zone.dimension());
    if (dimension < 2) throw Error(ErrorCode::unsupported, name_ + ": has " + (file_.zones.empty() ? "no zone" : "lines or points alone") + "; expected a zone with a volume or a surface");
    for (const std::string& said : file_.variables) variables_.push_back(variable_of(said));
    if (std::ssize(variables_) < dimension) throw Error(ErrorCode::bad_data, name_ + ": has " + std::to_string(variables_.size()) + " variables; expected x, y and z among them");
    place_ = places_of(variables_, dimension);

    Imported imported;
    std::vector<double> times;
    for (const TecplotZone& zone : file_.zones)
      if (zone.timed) times.push_back(zone.time);
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    if (!times.empty()) imported.times = times;
    check_step(request_, imported.times.size());
    if (request_.times_only) return imported;

    int lower = 0;
    for (std::size_t z = 0; z < file_.zones.size(); ++z) {
      const TecplotZone& zone = file_.zones[z];
      if (zone.timed && zone.time != imported.times[static_cast<std::size_t>(request_.step)]) continue;
      if (zone.dimension() < dimension) {
        ++lower;
        continue;
      }
      check_room(3 * sizeof(double), zone.points);
      const std::size_t before = imported.blocks.size();
      append_vtk_blocks(dataset_of(static_cast<int>(z)), request_, false, imported.blocks, imported.notes);
      for (std::size_t b = before; b < imported.blocks.size(); ++b) imported.blocks[b].name = zone.name.empty() ? "zone " + std::to_string(z + 1) : zone.name;
      request_.progress(static_cast<double>(z + 1) / static_cast<double>(file_.zones.size()));
    }
    if (lower > 0) imported.notes.push_back(std::to_string(lower) + " zones of lower dimension skipped");
    for (std::size_t a = 0; a < 3; ++a)
      if (place_[a]) imported.axes[a].unit = variables_[*place_[a]].unit;
    return imported;
  }

 private:
  void check_room(std::size_t width, std::int64_t count) {
    bytes_of_all_ += static_cast<std::uint64_t>(checked_product({static_cast<std::int64_t>(width), count}, name_));
    check_bytes(request_, bytes_of_all_, name_);
  }
  const TecplotNumbers& numbers(int zone) {
    const auto [at, fresh] = loaded_.try_emplace(zone);
    if (fresh) {
      const TecplotZone& of = file_.zones[static_cast<std::size_t>(zone)];
      for (const TecplotValues& values : of.values)
        if (!values.passive && values.shared_with < 0) check_room(size_of(values.type), of.count(values));
      if (of.mesh_of < 0) check_room(4 * sizeof(std::int64_t) * static_cast<std::size_t>(tecplot_nodes(of.kind)), of.cells);
      at->second = binary_ ? load_tecplot_binary(bytes_, file_, of, name_) : load_tecplot_text(text_, file_, of, name_);
    }
    return at->second;
  }
  /// The zone that has what this one has, perhaps through others before it.
  template <class Next>
  int owner(int zone, const Next& next) const {
    for (std::size_t hops = 0; hops <= file_.zones.size(); ++hops) {
      const int with = next(file_.zones[static_cast<std::size_t>(zone)]);
      if (with < 0) return zone;
      zone = with;
    }
    throw Error(ErrorCode::bad_data, name_ + ": zones share values in a circle");
  }
  /// Null if there are none.
  const FileArray* values_of(int zone, std::size_t variable) {
    const int from = owner(zone, [&](const TecplotZone& of) { return of.values[variable].shared_with; });
    const TecplotZone &own = file_.zones[static_cast<std::size_t>(zone)], &other = file_.zones[static_cast<std::size_t>(from)];
    if (other.values[variable].passive) return nullptr;
    const FileArray& values = numbers(from).values[variable];
    const bool cells = other.values[variable].on_cells;
    if ((cells ? own.cells : own.points) != (cells ? other.cells : other.points))
      throw Error(ErrorCode::bad_data, name_ + ": zones " + std::to_string(zone + 1) + " and " + std::to_string(from + 1) + " share '" + file_.variables[variable].substr(0, 40) + "', and are not of one size");
    return &values;
  }

  vtkSmartPointer<vtkPoints> points_of(int z) {
    const TecplotZone& zone = file_.zones[static_cast<std::size_t>(z)];
    vtkNew<vtkDoubleArray> places;
    places->SetNumberOfComponents(3);
    places->SetNumberOfTuples(zone.points);
    places->FillValue(0);
    for (std::size_t a = 0; a < 3; ++a) {
      if (!place_[a]) continue;
      const FileArray* of = values_of(z, *place_[a]);
      if (!of || of->on_cells) throw Error(ErrorCode::bad_data, name_ + ": zone " + std::to_string(z + 1) + " has no '" + file_.variables[*place_[a]].substr(0, 40) + "' at its points");
      double* to = places->GetPointer(0) + a;
      std::visit([&](auto values) { for (const auto value : values) *to = static_cast<double>(value), to += 3; }, scalar_span(of->type, of->values));
    }
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetData(places);
    return points;
  }

  vtkSmartPointer<vtkDataSet> dataset_of(int z) {
    const TecplotZone& zone = file_.zones[static_cast<std::size_t>(z)];
    vtkSmartPointer<vtkDataSet> out;
    if (zone.kind == TecplotKind::ordered) {
      vtkNew<vtkStructuredGrid> grid;
      grid->SetDimensions(static_cast<int>(zone.dims[0]), static_cast<int>(zone.dims[1]), static_cast<int>(zone.dims[2]));
      grid->SetPoints(points_of(z));
      out = grid;
    } else {
      vtkNew<vtkUnstructuredGrid> grid;
      grid->SetPoints(points_of(z));
      add_elements(grid, z);
      out = grid;
    }
    for (std::size_t v = 0; v < variables_.size(); ++v) {
      if (std::find(place_.begin(), place_.end(), v) != place_.end()) continue;
      const FileArray* of = values_of(z, v);
      if (!of) continue;
      auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(vtk_type_of(of->type)));
      array->SetNumberOfTuples(of->on_cells ? zone.cells : zone.points);
      std::memcpy(array->GetVoidPointer(0), of->values.data(), of->values.size());
      array->SetName(variables_[v].name.c_str());
      if (!variables_[v].unit.empty()) array->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), variables_[v].unit);
      static_cast<vtkFieldData*>(of->on_cells ? static_cast<vtkFieldData*>(out->GetCellData()) : out->GetPointData())->AddArray(array);
    }
    return out;
  }

  void add_elements(vtkUnstructuredGrid* grid, int z) {
    const TecplotZone& zone = file_.zones[static_cast<std::size_t>(z)];
    const int from = owner(z, [](const TecplotZone& of) { return of.mesh_of; });
    const TecplotZone& other = file_.zones[static_cast<std::size_t>(from)];
    if (other.kind != zone.kind || other.cells != zone.cells) throw Error(ErrorCode::bad_data, name_ + ": zones " + std::to_string(z + 1) + " and " + std::to_string(from + 1) + " share elements, and are not of one kind and size");
    const std::vector<std::int64_t>& nodes = numbers(from).nodes;
    const auto corners = static_cast<std::size_t>(tecplot_nodes(zone.kind));
    std::vector<std::uint8_t> types;
    std::vector<std::int64_t> ends{0}, ids;
    for (std::size_t c = 0; c < static_cast<std::size_t>(zone.cells); ++c) {
      const std::span<const std::int64_t> of(nodes.data() + c * corners, corners);
      for (const std::int64_t node : of)
        if (node < 0 || node >= zone.points) throw Error(ErrorCode::bad_data, name_ + ": element " + std::to_string(c + 1) + " of zone " + std::to_string(z + 1) + " has node " + std::to_string(node + 1) + "; there are " + std::to_string(zone.points));
      types.push_back(static_cast<std::uint8_t>(add_element(zone.kind, of, ids)));
      ends.push_back(std::ssize(ids));
    }
    set_cells(grid, types, ends, ids);
  }

  /// VTK's type. A quadrilateral or a brick whose nodes fall together is a simpler cell.
  static int add_element(TecplotKind kind, std::span<const std::int64_t> of, std::vector<std::int64_t>& ids) {
    const auto put = [&](int type, std::initializer_list<std::int64_t> some) {
      ids.insert(ids.end(), some);
      return type;
    };
    const auto ring = [](std::span<const std::int64_t> four) {  // without nodes that follow themselves
      std::vector<std::int64_t> out;
      for (std::size_t n = 0; n < 4; ++n)
        if (four[n] != four[(n + 1) % 4]) out.push_back(four[n]);
      if (out.empty()) out.push_back(four[0]);
      return out;
    };
    if (kind == TecplotKind::triangle) return put(VTK_TRIANGLE, {of[0], of[1], of[2]});
    if (kind == TecplotKind::tetrahedron) return put(VTK_TETRA, {of[0], of[1], of[2], of[3]});
    const auto low = ring(of.first(4));
    if (kind == TecplotKind::quadrilateral) {
      if (low.size() == 3) return put(VTK_TRIANGLE, {low[0], low[1], low[2]});
      return put(VTK_QUAD, {of[0], of[1], of[2], of[3]});
    }
    const auto high = ring(of.subspan(4));
    if (low.size() == 3 && high.size() == 1) return put(VTK_TETRA, {low[0], low[1], low[2], high[0]});
    if (low.size() == 4 && high.size() == 1) return put(VTK_PYRAMID, {low[0], low[1], low[2], low[3], high[0]});
    if (low.size() == 3 && high.size() == 3) return put(VTK_WEDGE, {low[0], low[1], low[2], high[0], high[1], high[2]});
    if (low.size() == 4 && high.size() == 2) {  // a roof over four nodes
      if (of[4] == of[5]) return put(VTK_WEDGE, {of[0], of[1], of[4], of[3], of[2], of[6]});
      return put(VTK_WEDGE, {of[0], of[3], of[4], of[1], of[2], of[5]});
    }
    ids.insert(ids.end(), of.begin(), of.end());
    return VTK_HEXAHEDRON;
  }

  const ReadRequest& request_;
  std::string name_;
  std::span<const std::byte> bytes_;
  std::string_view text_;
  bool binary_;
  TecplotFile file_;
  std::vector<Variable> variables_;
  std::array<std::optional<std::size_t>, 3> place_;
  std::map<int, TecplotNumbers> loaded_;
  std::uint64_t bytes_of_all_ = 0;
};

}  // namespace

Imported read_tecplot(const ReadRequest& request) {
  const MappedFile file(request.file);
  return Zones(request, file).read();
}

}  // namespace isostrata
