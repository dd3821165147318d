// MED, of Salome and Code_Aster: meshes and fields in HDF5, by HDF5's own library.
#include <vtkCellType.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "import/bytes/trimmed.h"
#include "import/hdf5/hdf5_file.h"
#include "import/imported/read_own.h"
#include "import/meshes/numbered_mesh.h"

namespace isostrata {
namespace {

/// The order of nodes is VTK's, seen from the other side: corners, edges around the first face, around the second, between both.
struct MedKind {
  const char* name;
  ElementKind kind;  // order: of the same cell turned over
};
const MedKind* med_kind(std::string_view name) {
  static const std::array kKinds{
      MedKind{"TE4", {0, 4, VTK_TETRA, 3, {0, 2, 1, 3}}},
      MedKind{"T10", {0, 10, VTK_QUADRATIC_TETRA, 3, {0, 2, 1, 3, 6, 5, 4, 7, 9, 8}}},
      MedKind{"PY5", {0, 5, VTK_PYRAMID, 3, {0, 3, 2, 1, 4}}},
      MedKind{"P13", {0, 13, VTK_QUADRATIC_PYRAMID, 3, {0, 3, 2, 1, 4, 8, 7, 6, 5, 9, 12, 11, 10}}},
      MedKind{"PE6", {0, 6, VTK_WEDGE, 3, {0, 2, 1, 3, 5, 4}}},
      MedKind{"P15", {0, 15, VTK_QUADRATIC_WEDGE, 3, {0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13}}},
      MedKind{"HE8", {0, 8, VTK_HEXAHEDRON, 3, {0, 3, 2, 1, 4, 7, 6, 5}}},
      MedKind{"H20", {0, 20, VTK_QUADRATIC_HEXAHEDRON, 3, {0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17}}},
      MedKind{"H27", {0, 27, VTK_QUADRATIC_HEXAHEDRON, 3, {0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17}}},
      MedKind{"TR3", {0, 3, VTK_TRIANGLE, 2, {}}},
      MedKind{"TR6", {0, 6, VTK_QUADRATIC_TRIANGLE, 2, {}}},
      MedKind{"QU4", {0, 4, VTK_QUAD, 2, {}}},
      MedKind{"QU8", {0, 8, VTK_QUADRATIC_QUAD, 2, {}}},
  };
  const auto at = std::find_if(kKinds.begin(), kKinds.end(), [&](const MedKind& of) { return of.name == name; });
  return at == kKinds.end() ? nullptr : &*at;
}

std::vector<std::string> names_along(std::string_view path) {
  std::vector<std::string> parts;
  while (!path.empty()) {
    const auto end = std::min(path.find('/'), path.size());
    if (end > 0) parts.emplace_back(path.substr(0, end));
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return parts;
}

/// A step of a field: its number and its order.
using Step = std::pair<std::int64_t, std::int64_t>;

/// CHA/FIELD/STEP/ENTITY/PROFILE/CO
struct FieldPart {
  const StoredArray* values = nullptr;
  std::string field, group, entity, profile, place;  // place: of its entity's group
  Step step;
};

class MedFile {
 public:
  explicit MedFile(const ReadRequest& request) : request_(request), name_(request.file.filename().string()), file_(request.file) {}

  Imported read() {
    find_mesh();
    find_fields();
    Imported imported;
    std::map<std::int64_t, double> by_step;
    for (const auto& [step, time] : steps_) by_step[std::ssize(by_step)] = time;
    if (!by_step.empty()) imported.times = times_of(by_step);
    check_step(request_, imported.times.size());
    if (request_.times_only) return imported;
    read_points();
    request_.progress(0.3);
    read_cells();
    request_.progress(0.6);
    read_fields();
    mesh_.append_to(imported, request_);
    for (FileArray& array : imported.blocks.back().arrays)
      if (const auto unit = units_.find(array.name); unit != units_.end()) array.unit = unit->second;
    const std::string units = file_.text("ENS_MAA/" + mesh_name_, "UNI");
    for (std::size_t a = 0; a < 3 && 16 * a < units.size(); ++a) imported.axes[a].unit = trimmed(units.substr(16 * a, 16));  // texts are filled up with blanks
    for (const std::string& note : notes_) add_note(imported.notes, note);
    return imported;
  }

 private:
  const StoredArray* find(const std::string& path) const {
    const auto at = std::find_if(file_.arrays().begin(), file_.arrays().end(), [&](const StoredArray& of) { return trimmed_path(of.path) == path; });
    return at == file_.arrays().end() ? nullptr : &*at;
  }
  static std::string_view trimmed_path(std::string_view path) { return path.starts_with('/') ? path.substr(1) : path; }

  template <class T>
  std::vector<T> numbers(const StoredArray& array, std::uint64_t expected) const {
    if (array.values() != expected)
      throw Error(ErrorCode::bad_data, name_ + ": '" + array.path + "' has " + std::to_string(array.values()) + " numbers; expected " + std::to_string(expected));
    check_bytes(request_, expected * (size_of(array.type) + sizeof(T)), name_);
    std::vector<std::byte> bytes(expected * size_of(array.type));
    if (expected > 0) file_.read(array, std::vector<std::size_t>(array.shape.size(), 0), array.shape, bytes);
    std::vector<T> out(expected);
    std::visit([&](auto from) { std::transform(from.begin(), from.end(), out.begin(), [](auto value) { return static_cast<T>(value); }); }, scalar_span(array.type, bytes));
    return out;
  }
  std::int64_t attribute(const char* name, const std::string& path, std::int64_t otherwise) const {
    const auto all = file_.numbers(name, path);
    return all.size() == 1 && std::abs(all[0]) < 1e15 ? static_cast<std::int64_t>(all[0]) : otherwise;
  }

  /// The one of most points; at its first step, since meshes that move are others.
  void find_mesh() {
    std::set<std::string> others;
    for (const StoredArray& array : file_.arrays()) {
      const std::string_view path = trimmed_path(array.path);
      if (!path.starts_with("ENS_MAA/") || !path.ends_with("/NOE/COO")) continue;
      others.insert(names_along(path).at(1));
      if (coordinates_ && array.values() <= coordinates_->values()) continue;
      coordinates_ = &array;
      mesh_path_ = std::string(path.substr(0, path.size() - std::string_view("/NOE/COO").size()));
    }
    if (!coordinates_) throw Error(ErrorCode::bad_data, name_ + ": a MED file without a mesh of cells (ENS_MAA/.../NOE/COO)");
    mesh_name_ = names_along(mesh_path_).at(1);
    if (others.size() > 1) notes_.push_back(std::to_string(others.size()) + " meshes, of which '" + mesh_name_ + "' is read, which has most points");
  }

  void find_fields() {
    for (const StoredArray& array : file_.arrays()) {
      const auto parts = names_along(trimmed_path(array.path));
      if (parts.size() != 6 || parts[0] != "CHA" || parts[5] != "CO") continue;
      const std::string field = "CHA/" + parts[1], group = field + "/" + parts[2];
      if (const std::string mesh{trimmed(file_.text(field, "MAI"))}; !mesh.empty() && mesh != mesh_name_) continue;
      if (!parts[3].starts_with("NOE") && !parts[3].starts_with("MAI.")) continue;
      if (parts[3].starts_with("NOE.")) {
        notes_.push_back("values at the corners of each cell are left out: " + parts[1]);
        continue;
      }
      const Step step{attribute("NDT", group, -1), attribute("NOR", group, -1)};
      const auto time = file_.numbers("PDT", group);
      const double at = time.size() == 1 && std::isfinite(time[0]) ? time[0] : 0;
      steps_.try_emplace(step, at);
      fields_.push_back({&array, parts[1], field, parts[3], parts[4], group + "/" + parts[3] + "/" + parts[4], step});
    }
  }

  void read_points() {
    const std::string maa = "ENS_MAA/" + mesh_name_;
    const auto count = static_cast<std::int64_t>(coordinates_->values());
    std::int64_t axes = attribute("ESP", maa, attribute("DIM", maa, 3));
    if (const std::int64_t said = attribute("NBR", mesh_path_ + "/NOE/COO", 0); said > 0 && count % said == 0) axes = count / said;
    if (axes < 2 || axes > 3 || count % axes != 0 || count == 0)
      throw Error(ErrorCode::bad_data, name_ + ": " + std::to_string(count) + " coordinates of " + std::to_string(axes) + " axes; expected as many along each of two or three");
    const auto places = numbers<double>(*coordinates_, static_cast<std::uint64_t>(count));
    const auto points = static_cast<std::size_t>(count / axes);
    mesh_.points.resize(points);
    for (std::size_t p = 0; p < points; ++p)
      for (std::size_t a = 0; a < static_cast<std::size_t>(axes); ++a) mesh_.points[p][static_cast<int>(a)] = places[a * points + p];
    for (std::size_t p = 1; p <= points; ++p) mesh_.nodes.add(static_cast<std::int64_t>(p));
    mesh_.nodes.close(name_, "nodes");
  }

  /// Of the highest dimension that there is.
  void read_cells() {
    std::vector<std::pair<const StoredArray*, const MedKind*>> all;
    int dimension = 0;
    for (const StoredArray& array : file_.arrays()) {
      const std::string_view path = trimmed_path(array.path);
      if (!path.starts_with(mesh_path_ + "/MAI/") || !path.ends_with("/NOD")) continue;
      const std::string type = names_along(path.substr(mesh_path_.size() + 5)).at(0);
      const MedKind* const kind = med_kind(type);
      if (kind) {
        all.emplace_back(&array, kind);
        dimension = std::max(dimension, kind->kind.dimension);
      } else if (type == "POE" || type == "POG" || type == "O12" || type == "TR7" || type == "QU9") {
        notes_.push_back("cells of type " + type + " are left out");
      }
    }
    if (all.empty()) throw Error(ErrorCode::bad_data, name_ + ": mesh '" + mesh_name_ + "' has no cells with an area or a volume");
    for (const auto& [array, kind] : all) {
      if (kind->kind.dimension < dimension) continue;
      const auto nodes = static_cast<std::size_t>(kind->kind.nodes);
      if (array->values() % nodes != 0)
        throw Error(ErrorCode::bad_data, name_ + ": '" + array->path + "' has " + std::to_string(array->values()) + " numbers; expected " + std::to_string(nodes) + " for each cell");
      const std::size_t cells = array->values() / nodes;
      first_[kind->name] = {mesh_.elements.size(), static_cast<std::int64_t>(cells)};
      const auto ids = numbers<std::int64_t>(*array, array->values());
      std::vector<std::int64_t> of(nodes);
      ElementKind as_is = kind->kind;
      as_is.order.clear();
      for (int v = 0; v < (kind->kind.nodes == 27 ? 20 : kind->kind.nodes); ++v) as_is.order.push_back(v);
      for (std::size_t cell = 0; cell < cells; ++cell) {
        for (std::size_t v = 0; v < nodes; ++v) of[v] = ids[v * cells + cell];
        mesh_.add_element(mesh_.elements.size(), is_turned_over(of, kind->kind) ? kind->kind : as_is, of, name_);
      }
    }
  }
  /// Against VTK's order, as the manual has its cells; some programs write them the other way.
  bool is_turned_over(const std::vector<std::int64_t>& ids, const ElementKind& kind) const {
    if (kind.dimension < 3) return false;
    const bool four_below = kind.vtk_type == VTK_HEXAHEDRON || kind.vtk_type == VTK_QUADRATIC_HEXAHEDRON || kind.vtk_type == VTK_PYRAMID || kind.vtk_type == VTK_QUADRATIC_PYRAMID;
    const std::array<std::size_t, 4> corners = four_below ? std::array<std::size_t, 4>{0, 1, 3, 4} : std::array<std::size_t, 4>{0, 1, 2, 3};
    std::array<Vec3d, 4> at;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto place = mesh_.nodes.place(ids[corners[i]]);
      if (!place) return false;  // whoever adds it says so
      at[i] = mesh_.points[static_cast<std::size_t>(*place)];
    }
    return orient3d(at[0], at[1], at[2], at[3]) < 0;
  }

  void read_fields() {
    if (fields_.empty()) return;
    const Step step = std::next(steps_.begin(), request_.step)->first;
    std::map<std::pair<std::string, bool>, std::size_t> arrays;  // by field, and whether it is on cells
    for (const FieldPart& part : fields_) {
      if (part.step != step) continue;
      const bool cells = part.entity != "NOE";
      std::pair<std::int64_t, std::int64_t> range{0, mesh_.nodes.size()};  // the first, how many
      if (cells) {
        const auto found = first_.find(part.entity.substr(4));
        if (found == first_.end()) continue;  // of cells that are not read
        range = found->second;
      }
      const std::int64_t components = attribute("NCO", part.group, 1), points = std::max<std::int64_t>(attribute("NGA", part.place, 1), 1);
      if (components < 1 || components > 256 || points > 4096)
        throw Error(ErrorCode::bad_data, name_ + ": field '" + part.field + "' has " + std::to_string(components) + " components at " + std::to_string(points) + " points of a cell");
      const auto [at, is_new] = arrays.try_emplace({part.field, cells}, mesh_.arrays.size());
      if (is_new) {
        const bool both = arrays.contains({part.field, !cells});
        mesh_.arrays.emplace_back(part.field + (both ? cells ? " (cells)" : " (nodes)" : ""), cells, static_cast<int>(components), cells ? mesh_.elements.size() : mesh_.nodes.size());
        if (const std::string unit{trimmed(file_.text(part.group, "UNI").substr(0, 16))}; !unit.empty()) units_[mesh_.arrays.back().name] = unit;
      }
      fill(part, mesh_.arrays[at->second], range, components, points);
    }
  }
  /// One component after the other, each with the points of one cell after those of the one before, whose mean is the cell's value.
  void fill(const FieldPart& part, NumberedArray& array, std::pair<std::int64_t, std::int64_t> range, std::int64_t components, std::int64_t points) {
    std::vector<std::int64_t> which;
    if (const StoredArray* const profile = find("PROFILS/" + part.profile + "/PFL")) which = numbers<std::int64_t>(*profile, profile->values());
    const std::int64_t tuples = which.empty() ? range.second : std::ssize(which);
    const auto values = numbers<double>(*part.values, static_cast<std::uint64_t>(checked_product({tuples, components, points}, name_)));
    for (std::int64_t t = 0; t < tuples; ++t) {
      const std::int64_t place = which.empty() ? t : which[static_cast<std::size_t>(t)] - 1;
      if (place < 0 || place >= range.second)
        throw Error(ErrorCode::bad_data, name_ + ": profile '" + part.profile + "' names " + std::to_string(place + 1) + "; there are " + std::to_string(range.second));
      const auto tuple = array.tuple(range.first + place);
      for (std::int64_t c = 0; c < components; ++c) {
        double sum = 0;
        for (std::int64_t g = 0; g < points; ++g) sum += values[static_cast<std::size_t>((c * tuples + t) * points + g)];
        tuple[static_cast<std::size_t>(c)] = sum / static_cast<double>(points);
      }
    }
    if (points > 1) notes_.push_back("values at several points of a cell become their mean: " + part.field);
  }

  const ReadRequest& request_;
  const std::string name_;
  const Hdf5File file_;
  const StoredArray* coordinates_ = nullptr;
  std::string mesh_path_, mesh_name_;
  std::map<Step, double> steps_;
  std::vector<FieldPart> fields_;
  std::map<std::string, std::pair<std::int64_t, std::int64_t>, std::less<>> first_;  // by type of cells: the first of them, how many
  std::map<std::string, std::string> units_;
  std::vector<std::string> notes_;
  NumberedMesh mesh_;
};

}  // namespace

Imported read_med(const ReadRequest& request) { return MedFile(request).read(); }

}  // namespace isostrata
