#include <vtkCellType.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "data/files/recognise.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/text_numbers.h"
#include "import/bytes/trimmed.h"
#include "import/imported/read_own.h"
#include "import/meshes/numbered_mesh.h"

namespace isostrata {
namespace {

/// A pyramid begins with its tip; wedges and hexahedra with the face that VTK has last.
const ElementKind* ucd_kind(std::string_view name) {
  static const std::array<std::pair<std::string_view, ElementKind>, 6> kKinds{{{"tet", {0, 4, VTK_TETRA, 3, {0, 1, 3, 2}}},
                                                                              {"pyr", {0, 5, VTK_PYRAMID, 3, {1, 2, 3, 4, 0}}},
                                                                              {"prism", {0, 6, VTK_WEDGE, 3, {3, 4, 5, 0, 1, 2}}},
                                                                              {"hex", {0, 8, VTK_HEXAHEDRON, 3, {4, 5, 6, 7, 0, 1, 2, 3}}},
                                                                              {"tri", {0, 3, VTK_TRIANGLE, 2, {}}},
                                                                              {"quad", {0, 4, VTK_QUAD, 2, {}}}}};
  const auto at = std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& of) { return of.first == name; });
  return at == kKinds.end() ? nullptr : &at->second;
}

constexpr std::int64_t kMostInUcd = std::int64_t{1} << 40;

class UcdText {
 public:
  explicit UcdText(const ReadRequest& request)
      : name_(request.file.filename().string()), file_(request.file), text_({reinterpret_cast<const char*>(file_.bytes().data()), file_.bytes().size()}, name_), request_(request) {}

  Imported read() {
    while (!text_.number_follows()) {
      if (!text_.next_line().starts_with('#')) throw Error(ErrorCode::bad_data, name_ + ": expected the numbers of nodes, cells and values behind its remarks");
    }
    const std::int64_t nodes = count("number of nodes"), cells = count("number of cells"), at_nodes = count("number of values at nodes"), in_cells = count("number of values in cells");
    text_.skip_line();
    read_nodes(nodes);
    read_cells(cells);
    if (at_nodes > 0) read_values(false, at_nodes);
    if (in_cells > 0) read_values(true, in_cells);
    Imported imported;
    mesh_.append_to(imported, request_);
    for (FileArray& array : imported.blocks.back().arrays)
      for (const auto& [called, unit] : units_)
        if (called == array.name) array.unit = unit;
    if (left_out_ > 0) imported.notes.push_back(std::to_string(left_out_) + " points and lines are left out");
    return imported;
  }

 private:
  /// That the file may have: each takes two bytes at least.
  std::int64_t count(const char* what) {
    const std::int64_t value = text_.integer(what, kMostInUcd);
    if (value < 0 || static_cast<std::uint64_t>(value) > text_.left() / 2 + 1)
      throw Error(ErrorCode::bad_data, name_ + ": " + std::to_string(value) + " as the " + what + ", and " + std::to_string(text_.left()) + " bytes left for them");
    return value;
  }

  void read_nodes(std::int64_t nodes) {
    for (std::int64_t n = 0; n < nodes; ++n) {
      mesh_.nodes.add(text_.integer("the number of a node", kMostInUcd));
      Vec3d at;
      for (int a = 0; a < 3; ++a) at[a] = text_.number("a place");
      mesh_.points.push_back(at);
    }
    mesh_.nodes.close(name_, "nodes");
  }
  void read_cells(std::int64_t cells) {
    std::vector<std::int64_t> numbers, ids;
    for (std::int64_t c = 0; c < cells; ++c) {
      const std::int64_t number = text_.integer("the number of a cell", kMostInUcd);
      text_.integer("a cell's material", kMostInUcd);
      const std::string type = small_letters(std::string(text_.word("a cell's type")));
      all_cells_.push_back(-1);
      if (type == "pt" || type == "line") {
        for (int v = 0; v < (type == "pt" ? 1 : 2); ++v) text_.integer("a node", kMostInUcd);
        ++left_out_;
        continue;
      }
      const ElementKind* const kind = ucd_kind(type);
      if (!kind) throw Error(ErrorCode::bad_data, name_ + ": cell " + std::to_string(number) + " is of type '" + type.substr(0, 32) + "'; expected pt, line, tri, quad, tet, pyr, prism or hex");
      ids.clear();
      for (int v = 0; v < kind->nodes; ++v) ids.push_back(text_.integer("a node", kMostInUcd));
      all_cells_.back() = mesh_.elements.size();
      mesh_.add_element(number, *kind, ids, name_);
    }
  }
  /// How many arrays and how many numbers each has; a line for each: its name and its unit; then a row for each node or cell.
  void read_values(bool in_cells, std::int64_t said) {
    const std::int64_t arrays = count("number of arrays");
    std::vector<std::int64_t> sizes;
    std::int64_t all = 0;
    for (std::int64_t a = 0; a < arrays; ++a) all += sizes.emplace_back(count("number of an array's components"));
    if (all != said || std::any_of(sizes.begin(), sizes.end(), [](std::int64_t size) { return size < 1 || size > 256; }))
      throw Error(ErrorCode::bad_data, name_ + ": arrays of " + std::to_string(all) + " numbers in all; expected " + std::to_string(said) + ", as its first line says, and 1 to 256 for each");
    text_.skip_line();
    const std::size_t first = mesh_.arrays.size();
    const std::int64_t tuples = in_cells ? mesh_.elements.size() : mesh_.nodes.size(), rows = in_cells ? std::ssize(all_cells_) : tuples;
    if (static_cast<std::uint64_t>(all) * static_cast<std::uint64_t>(rows) > text_.left() / 2 + 1) throw Error(ErrorCode::bad_data, name_ + ": ends within its values");
    check_bytes(request_, static_cast<std::uint64_t>(all * tuples) * sizeof(double), name_);
    for (std::int64_t a = 0; a < arrays; ++a) {
      const std::string_view line = text_.rest_of_line();
      const auto comma = std::min(line.find(','), line.size());
      mesh_.arrays.emplace_back(std::string(trimmed(line.substr(0, comma))), in_cells, static_cast<int>(sizes[static_cast<std::size_t>(a)]), tuples);
      if (comma < line.size()) units_.emplace_back(mesh_.arrays.back().name, std::string(trimmed(line.substr(comma + 1))));
    }
    for (std::int64_t row = 0; row < rows; ++row) {
      const std::int64_t number = text_.integer(in_cells ? "the number of a cell" : "the number of a node", kMostInUcd);
      const std::int64_t at = in_cells ? all_cells_[static_cast<std::size_t>(row)] : mesh_.nodes.place(number).value_or(-1);
      if (!in_cells && at < 0) throw Error(ErrorCode::bad_data, name_ + ": values of node " + std::to_string(number) + ", which is not there");
      for (std::size_t a = first; a < mesh_.arrays.size(); ++a)
        for (int c = 0; c < mesh_.arrays[a].components; ++c) {
          const double value = text_.number("a value");
          if (at >= 0) mesh_.arrays[a].tuple(at)[static_cast<std::size_t>(c)] = value;
        }
    }
  }

  const std::string name_;
  const MappedFile file_;
  TextNumbers text_;
  const ReadRequest& request_;
  NumberedMesh mesh_;
  std::vector<std::int64_t> all_cells_;  // where each of the file's is among those that are read; -1: nowhere
  std::vector<std::pair<std::string, std::string>> units_;
  std::int64_t left_out_ = 0;
};

}  // namespace

// AVS UCD as text: "Unstructured Cell Data" of the AVS Developer's Guide.
Imported read_ucd(const ReadRequest& request) {
  check_step(request, 1);
  return UcdText(request).read();
}

}  // namespace isostrata
