#include <vtkCellType.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "import/bytes/mapped_file.h"
#include "import/imported/read_own.h"
#include "import/meshes/gmsh_file.h"
#include "import/meshes/numbered_mesh.h"

namespace isostrata {
namespace {

const ElementKind* gmsh_kind(std::int64_t type) {
  static const std::array kKinds{
      ElementKind{1, 2, VTK_LINE, 1, {}},
      ElementKind{2, 3, VTK_TRIANGLE, 2, {}},
      ElementKind{3, 4, VTK_QUAD, 2, {}},
      ElementKind{4, 4, VTK_TETRA, 3, {}},
      ElementKind{5, 8, VTK_HEXAHEDRON, 3, {}},
      ElementKind{6, 6, VTK_WEDGE, 3, {}},
      ElementKind{7, 5, VTK_PYRAMID, 3, {}},
      ElementKind{8, 3, VTK_QUADRATIC_EDGE, 1, {}},
      ElementKind{9, 6, VTK_QUADRATIC_TRIANGLE, 2, {}},
      ElementKind{10, 9, VTK_BIQUADRATIC_QUAD, 2, {}},
      ElementKind{11, 10, VTK_QUADRATIC_TETRA, 3, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}},
      ElementKind{12, 27, VTK_TRIQUADRATIC_HEXAHEDRON, 3, {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26}},
      ElementKind{13, 18, VTK_BIQUADRATIC_QUADRATIC_WEDGE, 3, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16}},
      ElementKind{14, 14, VTK_QUADRATIC_PYRAMID, 3, {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12}},
      ElementKind{15, 1, VTK_VERTEX, 0, {}},
      ElementKind{16, 8, VTK_QUADRATIC_QUAD, 2, {}},
      ElementKind{17, 20, VTK_QUADRATIC_HEXAHEDRON, 3, {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15}},
      ElementKind{18, 15, VTK_QUADRATIC_WEDGE, 3, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11}},
      ElementKind{19, 13, VTK_QUADRATIC_PYRAMID, 3, {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12}},
  };
  return find_kind(kKinds, type);
}

/// A set of values as the head of its section describes it; the values follow.
struct GmshData {
  std::string name;
  double time = 0;
  std::int64_t step = 0, components = 1, tuples = 0;
  std::string_view kind;  // of the section
  GmshNumbers values;
};

class GmshReader {
 public:
  GmshReader(const ReadRequest& request, std::string_view text, std::string name) : request_(request), name_(std::move(name)), file_(text, name_) {}

  Imported run() {
    for (const auto& [called, section] : file_.sections)
      if (called == "NodeData" || called == "ElementData" || called == "ElementNodeData") data_.push_back(head_of(called, section));
    Imported imported;
    const std::map<std::int64_t, double> by_step = steps();
    imported.times = times_of(by_step);
    check_step(request_, imported.times.size());
    if (request_.times_only) return imported;
    read_nodes();
    read_entities("Entities", false);
    read_entities("PartitionedEntities", true);
    read_elements();
    request_.progress(0.5);
    add_groups(imported);
    for (GmshData& data : data_)
      if (data.step == std::next(by_step.begin(), request_.step)->first || single(data)) add(data, imported);
    mesh_.append_to(imported, request_);
    return imported;
  }

 private:
  GmshNumbers section(std::string_view of) const { return {file_.section(of), file_.form, name_}; }

  GmshData head_of(std::string_view kind, std::string_view text) const {
    GmshData out{.name = {}, .kind = kind, .values = {text, file_.form, name_}};
    TextNumbers& words = out.values.words();
    const auto many = [&](const char* what) { return out.values.count(words.integer(what, 1 << 20), 1, what); };
    for (std::int64_t i = 0, n = many("names of values"); i < n; ++i) {
      const std::string_view line = words.next_line();
      if (i == 0) out.name = line.size() > 1 && line.front() == '"' ? line.substr(1, line.size() - 2) : line;
    }
    for (std::int64_t i = 0, n = many("real numbers"); i < n; ++i)
      if (const double value = words.number("the time"); i == 0) out.time = value;
    std::array<std::int64_t, 3> whole{0, 1, 0};
    for (std::int64_t i = 0, n = many("whole numbers"); i < n; ++i)
      if (const std::int64_t value = words.integer("a whole number", std::int64_t{1} << 53); i < 3) whole[static_cast<std::size_t>(i)] = value;
    std::tie(out.step, out.components, out.tuples) = std::tuple(whole[0], whole[1], whole[2]);
    if (out.components < 1 || out.components > 9) throw Error(ErrorCode::bad_data, name_ + ": '" + out.name + "' has " + std::to_string(out.components) + " components; expected 1, 3 or 9");
    if (!std::isfinite(out.time)) throw Error(ErrorCode::bad_data, name_ + ": a time of '" + out.name + "' is not a finite number");
    if (file_.form.binary) words.skip_line();
    return out;
  }

  /// Their times by their numbers.
  std::map<std::int64_t, double> steps() const {
    std::map<std::int64_t, double> by_step;
    for (const GmshData& data : data_)
      if (!single(data)) by_step.emplace(data.step, data.time);
    if (by_step.empty()) by_step.emplace(data_.empty() ? 0 : data_.front().step, data_.empty() ? 0 : data_.front().time);
    return by_step;
  }

  /// Whether values of this name are there at one step alone: they are of all.
  bool single(const GmshData& data) const {
    return std::all_of(data_.begin(), data_.end(), [&](const GmshData& other) { return other.name != data.name || other.kind != data.kind || other.step == data.step; });
  }

  void add_node(GmshNumbers& numbers) {
    Vec3d at{};
    for (double* x : {&at.x, &at.y, &at.z}) *x = numbers.real("a place");
    mesh_.points.push_back(at);
  }

  void read_nodes() {
    GmshNumbers numbers = section("Nodes");
    if (file_.section("Nodes").empty()) throw Error(ErrorCode::bad_data, name_ + ": has no nodes; expected $Nodes");
    if (file_.form.version == 2) {
      const std::int64_t nodes = numbers.count(whole_line(numbers, "the number of nodes"), 8, "nodes");
      reserve(nodes);
      for (std::int64_t i = 0; i < nodes; ++i) {
        mesh_.nodes.add(numbers.integer("the number of a node"));
        add_node(numbers);
      }
    } else {
      const std::int64_t blocks = numbers.count(numbers.size("the number of blocks"), 1, "blocks of nodes");
      reserve(numbers.count(numbers.size("the number of nodes"), 8, "nodes"));
      static_cast<void>(numbers.size("a number")), static_cast<void>(numbers.size("a number"));
      for (std::int64_t b = 0; b < blocks; ++b) {
        const std::int64_t dimension = numbers.integer("a dimension");
        static_cast<void>(numbers.integer("an entity"));
        const std::int64_t parameters = numbers.integer("whether nodes have parameters") == 0 ? 0 : std::clamp<std::int64_t>(dimension, 0, 3);
        const std::int64_t nodes = numbers.count(numbers.size("the number of nodes"), 8, "nodes of a block");
        for (std::int64_t i = 0; i < nodes; ++i) mesh_.nodes.add(numbers.size("the number of a node"));
        for (std::int64_t i = 0; i < nodes; ++i) {
          add_node(numbers);
          for (std::int64_t p = 0; p < parameters; ++p) static_cast<void>(numbers.real("a parameter"));
        }
      }
    }
    mesh_.nodes.close(name_, "nodes");
  }

  void reserve(std::int64_t nodes) {
    check_bytes(request_, static_cast<std::uint64_t>(nodes) * sizeof(Vec3d), name_);
    mesh_.points.reserve(static_cast<std::size_t>(nodes));
  }

  static std::int64_t whole_line(GmshNumbers& numbers, const char* what) {
    const std::int64_t value = numbers.words().integer(what, std::int64_t{1} << 53);
    if (numbers.form().binary) numbers.words().skip_line();
    return value;
  }

  /// Which physical group each entity belongs to: the first of several.
  void read_entities(std::string_view called, bool partitioned) {
    if (file_.form.version == 2 || file_.section(called).empty()) return;
    GmshNumbers numbers = section(called);
    const auto skip = [&](std::int64_t count, std::size_t bytes, const auto& one) {
      for (count = numbers.count(count, bytes, "numbers"); count > 0; --count) one();
    };
    const auto integer = [&] { return numbers.integer("a number"); };
    const auto real = [&] { static_cast<void>(numbers.real("a place")); };
    if (partitioned) {
      static_cast<void>(numbers.size("the number of partitions"));
      skip(numbers.size("the number of ghosts"), 2, [&] { integer(), integer(); });
    }
    std::array<std::int64_t, 4> counts{};
    for (std::int64_t& count : counts) count = numbers.count(numbers.size("the number of entities"), 4, "entities");
    for (int dimension = 0; dimension < 4; ++dimension)
      for (std::int64_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) {
        const std::int64_t entity = integer();
        if (partitioned) {
          integer(), integer();
          skip(numbers.size("the number of partitions"), 1, integer);
        }
        skip(dimension == 0 ? 3 : 6, 1, real);
        std::int64_t group = 0;
        skip(numbers.size("the number of groups"), 1, [&] {
          const std::int64_t own = std::abs(integer());
          group = group == 0 ? own : group;
        });
        group_of_[{dimension, entity}] = group;
        if (dimension > 0) skip(numbers.size("the number of sides"), 1, integer);
      }
  }

  void read_elements() {
    GmshNumbers numbers = section("Elements");
    if (file_.section("Elements").empty()) throw Error(ErrorCode::bad_data, name_ + ": has no elements; expected $Elements");
    if (file_.form.version == 2) {
      std::int64_t left = numbers.count(whole_line(numbers, "the number of elements"), 4, "elements");
      while (left > 0) {
        const bool binary = file_.form.binary;
        std::int64_t number = binary ? 0 : numbers.integer("the number of an element");
        const ElementKind& kind = kind_of(numbers.integer("the type of an element"));
        const std::int64_t many = binary ? numbers.integer("the number of elements") : 1, tags = numbers.integer("the number of tags");
        if (many < 1 || many > left || tags < 0 || tags > 1 << 20) throw Error(ErrorCode::bad_data, name_ + ": " + std::to_string(many) + " elements of " + std::to_string(tags) + " tags in a block; " + std::to_string(left) + " are left");
        left -= many;
        for (std::int64_t i = 0; i < many; ++i) {
          if (binary) number = numbers.integer("the number of an element");
          std::int64_t group = 0;
          for (std::int64_t t = 0; t < tags; ++t)
            if (const std::int64_t tag = numbers.integer("a tag"); t == 0) group = std::abs(tag);
          add_element(numbers, number, kind, group, false);
        }
      }
    } else {
      const std::int64_t blocks = numbers.count(numbers.size("the number of blocks"), 1, "blocks of elements");
      for (int i = 0; i < 3; ++i) static_cast<void>(numbers.size("a number"));
      for (std::int64_t b = 0; b < blocks; ++b) {
        const auto dimension = static_cast<int>(numbers.integer("a dimension"));
        const auto group = group_of_.find({dimension, numbers.integer("an entity")});
        const ElementKind& kind = kind_of(numbers.integer("the type of elements"));
        const std::int64_t many = numbers.count(numbers.size("the number of elements"), 4, "elements of a block");
        for (std::int64_t i = 0; i < many; ++i) add_element(numbers, numbers.size("the number of an element"), kind, group == group_of_.end() ? 0 : group->second, true);
      }
    }
    mesh_.elements.close(name_, "elements");
  }

  const ElementKind& kind_of(std::int64_t type) const {
    if (const ElementKind* kind = gmsh_kind(type)) return *kind;
    throw Error(ErrorCode::unsupported, name_ + ": has elements of type " + std::to_string(type) + "; expected lines, triangles, quadrilaterals, tetrahedra, hexahedra, prisms and pyramids of first or second order");
  }

  void add_element(GmshNumbers& numbers, std::int64_t number, const ElementKind& kind, std::int64_t group, bool wide) {
    nodes_.clear();
    for (int v = 0; v < kind.nodes; ++v) nodes_.push_back(wide ? numbers.size("a node") : numbers.integer("a node"));
    mesh_.add_element(number, kind, nodes_, name_);
    kinds_.push_back(&kind);
    groups_.push_back(group);
    highest_ = std::max(highest_, kind.dimension);
    if (mesh_.ids.size() % (1 << 20) < 32) check_bytes(request_, mesh_.ids.size() * 24, name_);
  }

  /// The groups of the elements of the highest dimension as an array, if there are several.
  void add_groups(Imported& imported) {
    std::set<std::int64_t> there;
    for (std::size_t e = 0; e < groups_.size(); ++e)
      if (kinds_[e]->dimension == highest_) there.insert(groups_[e]);
    if (there.size() < 2) return;
    std::map<std::int64_t, std::string> names;
    TextNumbers words(file_.section("PhysicalNames"), name_);
    if (words.left() > 0) words.next_line();
    while (words.left() > 0) {
      const std::string_view line = words.next_line();
      TextNumbers of(line, name_);
      if (!of.number_follows()) continue;
      const std::int64_t dimension = of.integer("a dimension", 3), group = of.integer("a group", std::int64_t{1} << 53);
      const auto begin = line.find('"'), end = line.rfind('"');
      if (dimension == highest_ && begin < end) names[group] = line.substr(begin + 1, end - begin - 1);
    }
    NumberedArray array("physical group", true, 1, mesh_.elements.size());
    for (std::size_t e = 0; e < groups_.size(); ++e) array.values[e] = static_cast<double>(groups_[e]);
    mesh_.arrays.push_back(std::move(array));
    std::string note;
    for (const std::int64_t group : there)
      if (note.size() < 300) note += (note.empty() ? "physical groups: " : ", ") + std::to_string(group) + (group == 0 ? " none" : names.contains(group) ? " " + names[group] : "");
    imported.notes.push_back(note);
  }

  /// The array that a section has values for: partitions have one each.
  NumberedArray& array_of(const GmshData& data, bool on_cells) {
    const auto at = std::find_if(mesh_.arrays.begin(), mesh_.arrays.end(), [&](const NumberedArray& one) { return one.name == data.name && one.on_cells == on_cells && one.components == data.components; });
    if (at != mesh_.arrays.end()) return *at;
    const std::int64_t tuples = on_cells ? mesh_.elements.size() : mesh_.nodes.size();
    check_bytes(request_, (mesh_.arrays.size() + 1) * static_cast<std::uint64_t>(tuples * data.components) * sizeof(double), name_);
    return mesh_.arrays.emplace_back(data.name, on_cells, static_cast<int>(data.components), tuples);
  }

  void add(GmshData& data, Imported& imported) {
    const bool on_cells = data.kind == "ElementData";
    const auto width = static_cast<std::size_t>(data.components);
    data.values.count(data.tuples, 1 + width, "values");
    if (data.kind == "ElementNodeData") {
      add_means(data);
      add_note(imported.notes, "'" + data.name + "' is given at the corners of each cell: each point has their mean");
      return;
    }
    NumberedArray& array = array_of(data, on_cells);
    std::array<double, 9> tuple{};
    for (std::int64_t i = 0; i < data.tuples; ++i) {
      const std::int64_t number = data.values.integer("the number of a node or an element");
      for (std::size_t c = 0; c < width; ++c) tuple[c] = data.values.real("a value");
      const auto place = (on_cells ? mesh_.elements : mesh_.nodes).place(number);
      if (!place) throw Error(ErrorCode::bad_data, name_ + ": '" + data.name + "' has a value for " + (on_cells ? "element " : "node ") + std::to_string(number) + ", which is not there");
      std::copy_n(tuple.begin(), width, array.tuple(*place).begin());
    }
  }

  /// Values at the corners of each element, which need not agree with those of its neighbour: their means, by node.
  void add_means(GmshData& data) {
    NumberedArray& array = array_of(data, false);
    const auto width = static_cast<std::size_t>(data.components);
    std::vector<double> sums(array.values.size()), values;
    std::vector<std::int64_t> counts(static_cast<std::size_t>(mesh_.nodes.size()));
    for (std::int64_t i = 0; i < data.tuples; ++i) {
      const std::int64_t number = data.values.integer("the number of an element");
      const auto corners = static_cast<std::size_t>(data.values.count(data.values.integer("the number of its corners"), width, "values"));
      values.clear();
      for (std::size_t v = 0; v < corners * width; ++v) values.push_back(data.values.real("a value"));
      const auto element = mesh_.elements.place(number);
      if (!element) throw Error(ErrorCode::bad_data, name_ + ": '" + data.name + "' has values for element " + std::to_string(number) + ", which is not there");
      const auto e = static_cast<std::size_t>(*element), first = static_cast<std::size_t>(mesh_.ends[e]), nodes = static_cast<std::size_t>(mesh_.ends[e + 1]) - first;
      if (kinds_[e]->dimension < highest_) continue;
      for (std::size_t v = 0; v < nodes; ++v) {
        const std::size_t in_file = kinds_[e]->order.empty() ? v : static_cast<std::size_t>(kinds_[e]->order[v]);
        if (in_file >= corners) continue;
        const auto node = static_cast<std::size_t>(mesh_.ids[first + v]);
        ++counts[node];
        for (std::size_t c = 0; c < width; ++c) sums[node * width + c] += values[in_file * width + c];
      }
    }
    for (std::size_t node = 0; node < counts.size(); ++node)
      for (std::size_t c = 0; counts[node] > 0 && c < width; ++c) array.values[node * width + c] = sums[node * width + c] / static_cast<double>(counts[node]);
  }

  const ReadRequest& request_;
  const std::string name_;
  const GmshFile file_;
  NumberedMesh mesh_;
  std::vector<GmshData> data_;
  std::map<std::pair<int, std::int64_t>, std::int64_t> group_of_;       // by dimension and entity
  std::vector<const ElementKind*> kinds_;                               // [elements]
  std::vector<std::int64_t> groups_, nodes_;                            // [elements]; of one element
  int highest_ = 0;                                                     // dimension of an element
};

}  // namespace

// Sections "$Name" to "$EndName", which may stand in any order; numbers of nodes and elements have gaps. Described in Gmsh's manual, "File formats".
Imported read_gmsh(const ReadRequest& request) {
  const MappedFile file(request.file);
  return GmshReader(request, {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()}, request.file.filename().string()).run();
}

}  // namespace isostrata
