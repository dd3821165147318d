#include "import/adaptive/hyper_tree_file.h"

#include <vtkXMLDataElement.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "import/bytes/parsed_number.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostLevels = 48;
constexpr std::uint64_t kMostChildren = 27;

class TreeFile {
 public:
  TreeFile(const ReadRequest& request, std::vector<std::string>& notes) : request_(request), notes_(notes), name_(request.file.filename().string()) {}

  HyperTrees read() {
    auto xml = XmlArrays::open(request_.file);
    if (!xml) broken("is not well-formed XML, or packs its values in another way than by zlib or LZ4");
    xml_ = &*xml;
    const std::string_view version = attribute(xml->root(), "version");
    if (!version.starts_with("1.") && !version.starts_with("2."))
      throw Error(ErrorCode::unsupported, name_ + ": is a hyper tree grid of version '" + std::string(version) + "'; expected 1 or 2, as VTK writes since 9.0");
    const Element grid = child(xml->root(), "HyperTreeGrid"), trees = child(grid, "Trees");
    const auto factor = parsed_number<unsigned int>(attribute(grid, "BranchFactor"));
    if (!factor || *factor < 2 || *factor > 3) broken("its branch factor is '" + std::string(attribute(grid, "BranchFactor")) + "'; expected 2 or 3");
    out_.factor = *factor;
    out_.transposed = attribute(grid, "TransposedRootIndexing") == "1";
    const Element axes = child(grid, "Grid");
    for (std::size_t axis = 0; axis < 3; ++axis) read_axis(axis, numbers<double>(axes, std::string(1, "XYZ"[axis]) + "Coordinates"));
    if (version.starts_with("2."))
      read_lists(grid, trees);
    else
      read_elements(trees);
    return std::move(out_);
  }

 private:
  using Element = vtkXMLDataElement*;

  [[noreturn]] void broken(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": " + what); }

  Element child(Element of, const char* called) const {
    const Element found = of->FindNestedElementWithName(called);
    if (!found) broken("expected an element " + std::string(called) + " in " + of->GetName());
    return found;
  }

  static Element find(Element in, std::string_view array) {
    for (int i = 0; i < in->GetNumberOfNestedElements(); ++i)
      if (attribute(in->GetNestedElement(i), "Name") == array) return in->GetNestedElement(i);
    return nullptr;
  }

  Element required(Element in, const std::string& array) const {
    const Element found = find(in, array);
    if (!found) broken("expected an array '" + array + "' in " + in->GetName());
    return found;
  }

  /// What it takes in memory.
  void count(Element array) {
    const auto coded = xml_->coded(array);
    check_bytes(request_, bytes_ += coded ? coded->bytes : 0, name_ + ": its arrays");
  }

  FileArray values(Element array) {
    count(array);
    auto found = xml_->values(array);
    if (!found) broken("array '" + std::string(attribute(array, "Name")) + "' is damaged");
    return aligned(std::move(*found));
  }

  template <class T>
  std::vector<T> numbers(Element in, const std::string& array) {
    const FileArray found = values(required(in, array));
    if (std::is_integral_v<T> && (found.type == ScalarType::float32 || found.type == ScalarType::float64)) broken("array '" + array + "' holds " + to_string(found.type) + "; expected whole numbers");
    std::vector<T> out;
    std::visit([&](auto all) { out.assign(all.begin(), all.end()); }, scalar_span(found.type, found.values));
    return out;
  }

  XmlBits bits(Element array) {
    count(array);
    auto found = xml_->bits(array);
    if (attribute(array, "type") != "Bit" || !found) broken("array '" + std::string(attribute(array, "Name")) + "' is damaged; expected bits");
    return std::move(*found);
  }

  void read_axis(std::size_t axis, std::vector<double> places) {
    const std::string along = "the coordinates along " + std::string(1, "xyz"[axis]);
    if (places.empty()) broken(along + " are none");
    for (std::size_t p = 0; p < places.size(); ++p)
      if (!std::isfinite(places[p]) || (p > 0 && !(places[p] > places[p - 1]))) broken(along + " do not increase");
    out_.axes[axis] = std::move(places);
  }

  void add_tree(std::int64_t root, std::vector<std::uint64_t> cells, std::uint64_t first_bit) {
    if (cells.empty() || cells.size() > kMostLevels) broken("a tree has " + std::to_string(cells.size()) + " levels; expected 1 to " + std::to_string(kMostLevels));
    HyperTrees::Tree tree{.root = root, .cells = std::move(cells), .first_bit = first_bit, .first_cell = out_.cells};
    for (const std::uint64_t level : tree.cells)
      if (level > std::uint64_t{1} << 48 || (out_.cells += level) > std::uint64_t{1} << 48) broken("its trees have above 2^48 cells");
    out_.trees.push_back(std::move(tree));
  }

  void read_lists(Element grid, Element trees) {
    const auto roots = numbers<std::int64_t>(trees, "TreeIds"), depths = numbers<std::int64_t>(trees, "DepthPerTree");
    const auto cells = numbers<std::uint64_t>(trees, "NumberOfVerticesPerDepth");
    out_.refined = bits(required(trees, "Descriptors"));
    if (const Element mask = find(trees, "Mask")) out_.masked = bits(mask);
    if (depths.size() != roots.size()) broken("has " + std::to_string(roots.size()) + " trees, and depths of " + std::to_string(depths.size()));
    std::size_t at = 0;
    std::uint64_t bit = 0;
    for (std::size_t t = 0; t < roots.size(); ++t) {
      if (depths[t] < 1 || static_cast<std::uint64_t>(depths[t]) > cells.size() - at) broken("tree " + std::to_string(t) + " has " + std::to_string(depths[t]) + " levels, of which the numbers of cells are not there");
      const auto from = cells.begin() + static_cast<std::ptrdiff_t>(at);
      at += static_cast<std::size_t>(depths[t]);
      add_tree(roots[t], {from, from + depths[t]}, bit);
      bit = bit + out_.cells - out_.trees.back().first_cell - out_.trees.back().cells.back();
    }
    const Element of_cells = grid->FindNestedElementWithName("CellData");
    for (int i = 0; of_cells && i < of_cells->GetNumberOfNestedElements(); ++i) {
      const Element array = of_cells->GetNestedElement(i);
      if (!is_numbers(array)) continue;
      out_.values.push_back(values(array));
      check_count(out_.values.back(), out_.cells);
    }
  }

  void read_elements(Element trees) {
    std::map<std::string, std::vector<FileArray>> parts;
    std::vector<std::string> names;  // in their order
    for (int t = 0; t < trees->GetNumberOfNestedElements(); ++t) {
      const Element tree = trees->GetNestedElement(t);
      if (std::string_view(tree->GetName()) != "Tree") continue;
      const auto root = parsed_number<std::int64_t>(attribute(tree, "Index"));
      if (!root) broken("a tree has no number");
      const std::uint64_t before = out_.cells;
      add_tree(*root, numbers<std::uint64_t>(tree, "NbVerticesByLevel"), out_.refined.count);
      const XmlBits refined = bits(required(tree, "Descriptor"));  // without the last ones that are 0
      const std::uint64_t coarser = out_.cells - before - out_.trees.back().cells.back();
      if (out_.cells - before > 1 + refined.count * 2 * kMostChildren) broken("tree " + std::to_string(*root) + " has more cells than its descriptor refines");
      out_.refined.append(refined, coarser);
      if (const Element mask = find(tree, "Mask")) {
        out_.masked.append({}, before - out_.masked.count);
        const XmlBits masked = bits(mask);
        out_.masked.append(masked, std::min(masked.count, out_.cells - before));
      }
      const Element first = tree->FindNestedElementWithName("CellData"), of_cells = first ? first : tree->FindNestedElementWithName("PointData");
      for (int i = 0; of_cells && i < of_cells->GetNumberOfNestedElements(); ++i) {
        if (!is_numbers(of_cells->GetNestedElement(i))) continue;
        FileArray array = values(of_cells->GetNestedElement(i));
        check_count(array, out_.cells - before);
        auto& part = parts[array.name];
        if (part.empty()) names.push_back(array.name);
        part.push_back(std::move(array));
      }
    }
    for (const std::string& name : names) join(parts[name]);
  }

  /// The values of all trees as one array.
  void join(const std::vector<FileArray>& parts) {
    FileArray all = parts.front();
    std::size_t bytes = 0;
    for (const FileArray& part : parts) {
      bytes += part.values.size();
      if (part.type != all.type || part.components != all.components) broken("array '" + all.name + "' is of several types");
    }
    if (parts.size() != out_.trees.size()) broken("array '" + all.name + "' is in " + std::to_string(parts.size()) + " of " + std::to_string(out_.trees.size()) + " trees");
    auto [storage, to] = allocate<std::byte>(bytes);
    std::size_t at = 0;
    for (const FileArray& part : parts) at = static_cast<std::size_t>(std::copy(part.values.begin(), part.values.end(), to.begin() + static_cast<std::ptrdiff_t>(at)) - to.begin());
    all.values = to;
    all.storage = storage;
    out_.values.push_back(std::move(all));
  }

  bool is_numbers(Element array) {
    const std::string_view type = attribute(array, "type"), name = attribute(array, "Name");
    if (name == "vtkGhostType") return false;
    if (type != "String" && type != "Bit") return true;
    add_note(notes_, "array '" + std::string(name) + "' skipped: it holds " + std::string(type) + ", not numbers");
    return false;
  }

  void check_count(const FileArray& array, std::uint64_t cells) const {
    const std::uint64_t tuples = array.values.size() / (size_of(array.type) * static_cast<std::size_t>(array.components));
    if (tuples != cells) broken("array '" + array.name + "' has " + std::to_string(tuples) + " tuples; expected " + std::to_string(cells));
  }

  const ReadRequest& request_;
  std::vector<std::string>& notes_;
  const std::string name_;
  const XmlArrays* xml_ = nullptr;
  std::uint64_t bytes_ = 0;
  HyperTrees out_;
};

}  // namespace

HyperTrees read_hyper_trees(const ReadRequest& request, std::vector<std::string>& notes) { return TreeFile(request, notes).read(); }

}  // namespace isostrata
