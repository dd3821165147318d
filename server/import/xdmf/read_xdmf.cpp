#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "import/bytes/parsed_number.h"
#include "import/imported/read_own.h"
#include "import/imported/vtk_messages.h"
#include "import/vtk/vtk_blocks.h"
#include "import/xdmf/xdmf_file.h"
#include "import/xdmf/xdmf_grid.h"
#include "import/xdmf/xdmf_values.h"

namespace isostrata {
namespace {

constexpr int kDeepestGrids = 32;  // of grids within grids
constexpr std::size_t kMostXdmfSteps = 1'000'000, kMostXdmfGrids = 100'000;

/// A grid that has a mesh, with all that is said of that mesh's points and cells.
struct XdmfLeaf {
  XdmfElement topology, geometry;
  std::string name;
  std::vector<XdmfElement> attributes;
};

class XdmfReader {
 public:
  explicit XdmfReader(const ReadRequest& request) : request_(request), name_(request.file.filename().string()), file_(request), values_(request, file_) {}

  Imported run() {
    std::vector<XdmfElement> grids;
    for (const XdmfElement& domain : file_.children(file_.root(), "Domain"))
      for (const XdmfElement& grid : file_.children(domain, "Grid")) grids.push_back(grid);
    if (grids.empty()) throw Error(ErrorCode::bad_data, name_ + ": has no Grid in a Domain");
    std::set<double> times;
    bool series = false;
    for (const XdmfElement& grid : grids) series = add_times(grid, 0, times) || series;
    Imported imported;
    if (!times.empty()) imported.times.assign(times.begin(), times.end());
    check_step(request_, imported.times.size());
    if (request_.times_only) return imported;
    const double time = imported.times[static_cast<std::size_t>(request_.step)];
    for (const XdmfElement& grid : grids) {
      const bool mesh_alone = series && !is_collection(grid) && !raw_time(grid) && file_.children(grid, "Attribute").empty();
      if (!mesh_alone) add_leaves(grid, times.empty() ? std::nullopt : std::optional(time), 0);
    }
    if (leaves_.empty()) throw Error(ErrorCode::bad_data, name_ + ": has no grid with a Topology and a Geometry" + (times.empty() ? "" : " at time " + std::to_string(time)));
    for (std::size_t l = 0; l < leaves_.size(); ++l) {
      read(leaves_[l], imported);
      request_.progress(static_cast<double>(l + 1) / static_cast<double>(leaves_.size()));
    }
    for (const std::string& note : notes_) add_note(imported.notes, note);
    return imported;
  }

 private:
  static bool is_temporal(const XdmfElement& grid) { return grid.word({"GridType"}) == "collection" && grid.word({"CollectionType"}) == "temporal"; }
  static bool is_collection(const XdmfElement& grid) { return grid.word({"GridType"}) == "collection" || grid.word({"GridType"}) == "tree"; }

  double time_in(std::string_view text) const {
    const auto time = parsed_number<double>(text.starts_with('+') ? text.substr(1) : text);
    if (!time || !std::isfinite(*time)) throw Error(ErrorCode::bad_data, name_ + ": a time '" + std::string(text.substr(0, 40)) + "' is not a finite number");
    return *time;
  }

  static XdmfElement raw_child(const XdmfElement& of, std::string_view name) {
    for (int i = 0; i < of.xml->GetNumberOfNestedElements(); ++i)
      if (XdmfElement one{of.xml->GetNestedElement(i), of.file}; one.is(name)) return one;
    return {};
  }

  /// What a grid says of itself; without a look at what its other elements refer to, since there may be thousands of such.
  std::optional<double> raw_time(const XdmfElement& grid) {
    const XdmfElement time = raw_child(grid, "Time");
    if (!time) return std::nullopt;
    std::string value = time.attribute("Value");
    value.erase(0, value.find_first_not_of(" \t\r\n"));
    value.erase(value.find_last_not_of(" \t\r\n") + 1);
    if (!value.empty()) return time_in(value);
    const XdmfElement item = raw_child(time, "DataItem");
    if (!item || time.word({"TimeType"}) == "list" || time.word({"TimeType"}) == "hyperslab" || time.word({"TimeType"}) == "range") return std::nullopt;
    const std::vector<double> numbers = values_.read(item).real();
    return numbers.size() == 1 ? std::optional(numbers.front()) : std::nullopt;
  }

  /// Of a grid or of the first one within it.
  std::optional<double> first_time(const XdmfElement& grid, int depth) {
    if (const auto own = raw_time(grid)) return own;
    if (depth >= kDeepestGrids || !is_collection(grid)) return std::nullopt;
    const XdmfElement inner = raw_child(grid, "Grid");
    return inner ? first_time(inner, depth + 1) : std::nullopt;
  }

  /// The times of the grids of a temporal collection: those that it lists, those that they say, else their numbers.
  const std::vector<std::pair<double, XdmfElement>>& steps_of(const XdmfElement& collection) {
    const auto known = steps_.find(collection.xml);
    if (known != steps_.end()) return known->second;
    const std::vector<XdmfElement> grids = file_.children(collection, "Grid");
    if (grids.size() > kMostXdmfSteps) throw Error(ErrorCode::too_large, name_ + ": more than " + std::to_string(kMostXdmfSteps) + " steps");
    std::vector<double> listed;
    if (const XdmfElement time = file_.child(collection, "Time")) {
      const std::string type = time.word({"TimeType", "Type"});
      const XdmfElement item = file_.child(time, "DataItem");
      if (item && (type == "list" || type == "hyperslab")) listed = values_.read(item).real();
      if (type == "hyperslab" && listed.size() == 3) {
        const double start = listed[0], stride = listed[1];
        listed.resize(grids.size());
        for (std::size_t i = 0; i < listed.size(); ++i) listed[i] = start + static_cast<double>(i) * stride;
      }
      if (!listed.empty() && listed.size() < grids.size())
        throw Error(ErrorCode::bad_data, name_ + ": " + std::to_string(listed.size()) + " times for " + std::to_string(grids.size()) + " grids of a temporal collection");
      for (const double one : listed)
        if (!std::isfinite(one)) throw Error(ErrorCode::bad_data, name_ + ": a time is not a finite number");
    }
    std::vector<std::pair<double, XdmfElement>> steps;
    for (std::size_t i = 0; i < grids.size(); ++i) steps.emplace_back(!listed.empty() ? listed[i] : first_time(grids[i], 0).value_or(static_cast<double>(i)), grids[i]);
    return steps_.emplace(collection.xml, std::move(steps)).first->second;
  }

  /// Whether there is a temporal collection in it.
  bool add_times(const XdmfElement& grid, int depth, std::set<double>& times) {
    if (depth > kDeepestGrids) throw Error(ErrorCode::bad_data, name_ + ": grids within grids, more than " + std::to_string(kDeepestGrids) + " deep");
    if (is_temporal(grid)) {
      for (const auto& [time, of] : steps_of(grid)) times.insert(time);
      return true;
    }
    if (const auto own = raw_time(grid)) {
      times.insert(*own);
      return false;
    }
    bool series = false;
    if (is_collection(grid))
      for (const XdmfElement& inner : file_.children(grid, "Grid")) series = add_times(inner, depth + 1, times) || series;
    return series;
  }

  /// Those at a time; without one, all.
  void add_leaves(const XdmfElement& grid, std::optional<double> time, int depth) {
    if (depth > kDeepestGrids) throw Error(ErrorCode::bad_data, name_ + ": grids within grids, more than " + std::to_string(kDeepestGrids) + " deep");
    if (is_temporal(grid)) {
      const auto& steps = steps_of(grid);
      const auto at = std::find_if(steps.rbegin(), steps.rend(), [&](const auto& step) { return !time || step.first == *time; });  // of two at one time the later one
      if (at != steps.rend()) add_leaves(at->second, std::nullopt, depth + 1);
      return;
    }
    if (const auto own = time ? raw_time(grid) : std::nullopt) {
      if (*own != *time) return;
      time.reset();
    }
    if (is_collection(grid)) {
      for (const XdmfElement& inner : file_.children(grid, "Grid")) add_leaves(inner, time, depth + 1);
      return;
    }
    if (const std::string type = grid.word({"GridType"}); !type.empty() && type != "uniform") {
      notes_.push_back("grids of GridType " + type + " are skipped");
      return;
    }
    add_leaf(grid);
  }

  void add_leaf(const XdmfElement& grid) {
    XdmfLeaf leaf;
    leaf.name = grid.attribute("Name");
    for (const XdmfElement& part : file_.children(grid)) {
      if (part.is("Topology")) leaf.topology = part;
      if (part.is("Geometry")) leaf.geometry = part;
      if (part.is("Attribute")) leaf.attributes.push_back(part);
      if (part.is("Set")) notes_.push_back("sets of points, faces or cells are skipped");
    }
    if (!leaf.topology && !leaf.geometry) return;
    if (!leaf.topology || !leaf.geometry)
      throw Error(ErrorCode::bad_data, name_ + ": grid '" + leaf.name + "' has no " + (leaf.topology ? "Geometry" : "Topology"));
    std::string mesh;
    describe(leaf.topology, mesh);
    describe(leaf.geometry, mesh);
    if (const auto known = of_mesh_.find(mesh); known != of_mesh_.end()) {
      auto& attributes = leaves_[known->second].attributes;
      attributes.insert(attributes.end(), leaf.attributes.begin(), leaf.attributes.end());
      return;
    }
    if (leaves_.size() == kMostXdmfGrids) throw Error(ErrorCode::too_large, name_ + ": more than " + std::to_string(kMostXdmfGrids) + " grids");
    of_mesh_.emplace(std::move(mesh), leaves_.size());
    leaves_.push_back(std::move(leaf));
  }

  /// All that makes a mesh the one that it is: where its numbers lie, or which element has them.
  void describe(const XdmfElement& element, std::string& to) {
    constexpr std::size_t kLongestPlace = 1000;
    to += std::string("<") + element.xml->GetName();
    for (int a = 0; a < element.xml->GetNumberOfAttributes(); ++a)
      if (const std::string name = element.xml->GetAttributeName(a); name != "Name") to += " " + name + "=" + element.xml->GetAttributeValue(a);
    const std::string_view text = element.text();
    if (text.size() <= kLongestPlace)
      to += ">" + element.file->string() + "|" + std::string(text);
    else
      to += ">" + std::to_string(reinterpret_cast<std::uintptr_t>(element.xml));
    for (const XdmfElement& inner : file_.children(element)) describe(inner, to);
  }

  void read(const XdmfLeaf& leaf, Imported& imported) {
    XdmfKept keep;
    const vtkSmartPointer<vtkDataSet> data = xdmf_grid(leaf.topology, leaf.geometry, file_, values_, request_, keep);
    for (const XdmfElement& attribute : leaf.attributes) add(attribute, data, keep);
    throw_on_vtk_error(name_);
    const std::size_t before = imported.blocks.size();
    append_vtk_blocks(data, request_, false, imported.blocks, notes_);
    const auto owner = std::make_shared<XdmfKept>(std::move(keep));
    using Both = std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>;
    for (std::size_t b = before; b < imported.blocks.size(); ++b) {
      Block& block = imported.blocks[b];
      block.name = leaf.name;
      block.grid.storage = std::make_shared<Both>(block.grid.storage, owner);
      for (FileArray& array : block.arrays) array.storage = std::make_shared<Both>(array.storage, owner);
    }
  }

  void add(const XdmfElement& attribute, vtkDataSet* data, XdmfKept& keep) {
    const std::string called = attribute.attribute("Name"), center = attribute.word({"Center"});
    const std::vector<XdmfElement> items = file_.children(attribute, "DataItem");
    const bool on_cells = center == "cell", on_points = center.empty() || center == "node";
    if (items.empty() || (!on_cells && !on_points && center != "grid") || !attribute.attribute("ItemType").empty()) {
      notes_.push_back("array '" + called + "' skipped: " + (items.empty() ? "it has no DataItem" : !on_cells && !on_points ? "its Center is " + attribute.attribute("Center") : "it is a " + attribute.attribute("ItemType")));
      return;
    }
    const XdmfArray array = values_.read(items.front());
    if (center == "grid") {
      if (array.count() == 1) notes_.push_back(called + ": " + number(array.real().front()));
      return;
    }
    const vtkIdType tuples = on_cells ? data->GetNumberOfCells() : data->GetNumberOfPoints();
    const std::size_t count = array.count();
    if (tuples < 1 || count == 0 || count % static_cast<std::size_t>(tuples) != 0 || count / static_cast<std::size_t>(tuples) > 1000)
      throw Error(ErrorCode::bad_data, name_ + ": array '" + called + "' has " + std::to_string(count) + " values for " + std::to_string(tuples) + (on_cells ? " cells" : " points"));
    const auto values = vtk_array(array, static_cast<int>(count / static_cast<std::size_t>(tuples)), keep);
    values->SetName(called.c_str());
    (on_cells ? static_cast<vtkFieldData*>(data->GetCellData()) : data->GetPointData())->AddArray(values);
  }

  static std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
  }

  const ReadRequest& request_;
  const std::string name_;
  XdmfFile file_;
  XdmfValues values_;
  std::map<const vtkXMLDataElement*, std::vector<std::pair<double, XdmfElement>>> steps_;
  std::vector<XdmfLeaf> leaves_;
  std::map<std::string, std::size_t> of_mesh_;  // which leaf has a mesh
  std::vector<std::string> notes_;
};

}  // namespace

Imported read_xdmf(const ReadRequest& request) { return XdmfReader(request).run(); }

}  // namespace isostrata
