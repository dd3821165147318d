#include "data/parts/partition.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

#include "data/parts/region.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr std::uintmax_t kMostPartsFile = 64u << 20;
constexpr int kMostDepth = 64;
constexpr std::size_t kMostParts = 1u << 16, kMostArraysOfParts = 20000;
constexpr std::int64_t kMostPointsOfParts = std::int64_t{1} << 56;
constexpr std::array kTypes{ScalarType::int8,   ScalarType::uint8, ScalarType::int16,  ScalarType::uint16,  ScalarType::int32,
                            ScalarType::uint32, ScalarType::int64, ScalarType::uint64, ScalarType::float32, ScalarType::float64};

/// Looks up and checks; every refusal says where.
class PartsReader {
 public:
  explicit PartsReader(const std::string& name) : name_(name) {}

  [[noreturn]] void refuse(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": " + what); }

  const json::value& need(const json::object& from, const char* key) const {
    const json::value* value = from.if_contains(key);
    if (!value) refuse(std::string("'") + key + "' is missing");
    return *value;
  }
  const json::object& object(const json::value& value, const char* what) const {
    if (!value.is_object()) refuse(std::string(what) + " is not an object");
    return value.get_object();
  }
  const json::array& list(const json::object& from, const char* key, std::size_t least, std::size_t most) const {
    const json::value& value = need(from, key);
    if (!value.is_array() || value.get_array().size() < least || value.get_array().size() > most)
      refuse(std::string("'") + key + "' is not a list of " + (least == most ? "" : std::to_string(least) + " to ") + std::to_string(most));
    return value.get_array();
  }
  std::string text(const json::object& from, const char* key) const {
    const json::value& value = need(from, key);
    if (!value.is_string() || value.get_string().empty()) refuse(std::string("'") + key + "' is not a text");
    return std::string(value.get_string());
  }
  std::int64_t integer(const json::value& value, const char* what, std::int64_t least, std::int64_t most) const {
    if (!value.is_int64() || value.get_int64() < least || value.get_int64() > most)
      refuse(std::string("'") + what + "' is " + json::serialize(value).substr(0, 40) + "; expected a whole number from " + std::to_string(least) + " to " + std::to_string(most));
    return value.get_int64();
  }
  std::int64_t integer(const json::object& from, const char* key, std::int64_t least, std::int64_t most) const {
    return integer(need(from, key), key, least, most);
  }
  double number(const json::value& value, const char* what) const {
    const double out = value.is_double() ? value.get_double() : value.is_int64() ? static_cast<double>(value.get_int64()) : NAN;
    if (!std::isfinite(out)) refuse(std::string("'") + what + "' is not a finite number");
    return out;
  }
  Vec3d vector(const json::object& from, const char* key) const {
    const json::array& of = list(from, key, 3, 3);
    return {number(of[0], key), number(of[1], key), number(of[2], key)};
  }
  std::array<std::int64_t, 3> indices(const json::object& from, const char* key, std::int64_t least) const {
    const json::array& of = list(from, key, 3, 3);
    std::array<std::int64_t, 3> out;
    for (std::size_t a = 0; a < 3; ++a) out[a] = integer(of[a], key, least, std::int64_t{1} << 31);
    return out;
  }

 private:
  const std::string& name_;
};

/// Each plane but the first is below just one other, and each part too, so that a walk visits all of them once and ends, soon.
void check_tree(const PartsReader& reader, const RegionTree& tree) {
  const std::size_t count = std::min<std::size_t>(tree.nodes.size(), kMostParts);  // it is no more; GCC 14 cannot know that, and warns
  const auto nodes = static_cast<std::int64_t>(count);
  std::vector<int> planes(count), parts(count + 1), depth(count);
  for (std::int64_t n = 0; n < nodes; ++n)
    for (const int child : {tree.nodes[static_cast<std::size_t>(n)].below, tree.nodes[static_cast<std::size_t>(n)].above}) {
      if (child >= 0 && child <= n) reader.refuse("'planes': plane " + std::to_string(n) + " leads back to plane " + std::to_string(child));
      if (child >= 0 && (depth[static_cast<std::size_t>(child)] = depth[static_cast<std::size_t>(n)] + 1) > kMostDepth) reader.refuse("'planes' are not halves of halves: one lies below more than " + std::to_string(kMostDepth));
      ++(child >= 0 ? planes[static_cast<std::size_t>(child)] : parts[static_cast<std::size_t>(~child)]);
    }
  const auto once = [](int times) { return times == 1; };
  if (!std::all_of(planes.begin() + (nodes > 0), planes.end(), once) || (nodes > 0 && !std::all_of(parts.begin(), parts.end(), once)))
    reader.refuse("'planes' are not a tree that has each part once");
}

json::array json_of(const Vec3d& v) { return {v.x, v.y, v.z}; }
json::array json_of(const std::array<std::int64_t, 3>& of) { return {of[0], of[1], of[2]}; }

DatasetParts read_manifest(const json::object& root, const PartsReader& reader) {
  DatasetParts out;
  if (reader.integer(root, "format", 0, 1 << 20) != 1) reader.refuse("'format' is another one than 1, which this version reads");
  out.grid = reader.text(root, "grid");
  out.points = reader.integer(root, "points", 1, kMostPointsOfParts);
  out.cells = reader.integer(root, "cells", 1, kMostPointsOfParts);
  for (const auto& [type, count] : reader.object(reader.need(root, "cell_types"), "'cell_types'")) out.cell_types[type] = reader.integer(count, "cell_types", 0, kMostPointsOfParts);
  const json::array& bounds = reader.list(root, "bounds", 3, 3);
  for (int a = 0; a < 3; ++a) {
    const json::value& of = bounds[static_cast<std::size_t>(a)];
    if (!of.is_array() || of.get_array().size() != 2) reader.refuse("'bounds' are not three pairs");
    out.bounds.lower[a] = reader.number(of.get_array()[0], "bounds");
    out.bounds.upper[a] = reader.number(of.get_array()[1], "bounds");
  }
  const bool structured = out.grid != "unstructured";
  if (structured) out.dims = reader.indices(root, "dims", 1);
  if (out.grid == "uniform") out.origin = reader.vector(root, "origin"), out.spacing = reader.vector(root, "spacing");
  for (const json::value& entry : reader.list(root, "arrays", 0, kMostArraysOfParts)) {
    const json::object& of = reader.object(entry, "an array");
    DatasetParts::Array array{reader.text(of, "name"), {}, INFINITY, -INFINITY, reader.integer(of, "nan_count", 0, kMostPointsOfParts)};
    const std::string type = reader.text(of, "type");
    const auto known = std::find_if(kTypes.begin(), kTypes.end(), [&](ScalarType t) { return type == to_string(t); });
    if (known == kTypes.end()) reader.refuse("array '" + array.name + "' is of type '" + type + "'");
    array.type = *known;
    if (!reader.need(of, "range").is_null()) {
      const json::array& range = reader.list(of, "range", 2, 2);
      array.lower = reader.number(range[0], "range"), array.upper = reader.number(range[1], "range");
    }
    out.arrays.push_back(std::move(array));
  }
  for (const json::value& entry : reader.list(root, "parts", 1, kMostParts)) {
    const json::object& of = reader.object(entry, "a part");
    DatasetParts::Part part{.file = reader.text(of, "file"), .points = reader.integer(of, "points", 1, out.points), .cells = reader.integer(of, "cells", 1, out.cells), .own_cells = reader.integer(of, "own_cells", 0, out.cells)};
    if (part.file.find_first_of(std::string_view("/\0", 2)) != std::string::npos || part.file == "." || part.file == "..")
      reader.refuse("part '" + part.file + "' is not a file beside the list");
    if (structured) part.first = reader.indices(of, "first", 0);
    out.parts.push_back(std::move(part));
  }
  const auto parts = static_cast<std::int64_t>(out.parts.size());
  for (const json::value& entry : reader.list(root, "planes", out.parts.size() - 1, out.parts.size() - 1)) {
    const json::object& of = reader.object(entry, "a plane");
    out.regions.nodes.push_back({static_cast<int>(reader.integer(of, "axis", 0, 2)), reader.number(reader.need(of, "at"), "at"),
                                 static_cast<int>(reader.integer(of, "below", -parts, parts - 2)), static_cast<int>(reader.integer(of, "above", -parts, parts - 2))});
  }
  check_tree(reader, out.regions);
  return out;
}

/// Of a uniform grid, positions have the bits that they have in the whole.
void place_in_whole(const DatasetParts& partition, const DatasetParts::Part& part, Grid& grid) {
  const auto* piece = std::get_if<UniformGrid>(&grid.shape);
  if (!piece) return;
  Grid whole;
  whole.shape = UniformGrid{partition.dims, partition.origin, partition.spacing};
  RectilinearGrid placed{piece->dims, {}};
  std::int64_t stride = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::int64_t i = 0; i < piece->dims[a]; ++i) placed.axes[a].push_back(whole.point((part.first[a] + i) * stride)[static_cast<int>(a)]);
    stride *= partition.dims[a];
  }
  grid.shape = std::move(placed);
}

/// Cells that other pieces have as their own are cells of the part.
void show_ghosts(Grid& grid) {
  if (std::none_of(grid.hidden_cells.begin(), grid.hidden_cells.end(), [](std::uint8_t hidden) { return hidden == kGhostCell; })) return;
  using Kept = std::pair<std::shared_ptr<const void>, std::vector<std::uint8_t>>;
  auto kept = std::make_shared<Kept>(grid.storage, std::vector<std::uint8_t>(grid.hidden_cells.begin(), grid.hidden_cells.end()));
  bool any = false;
  for (std::uint8_t& hidden : kept->second) {
    hidden = hidden != 0 && hidden != kGhostCell;
    any = any || hidden != 0;
  }
  grid.hidden_cells = any ? std::span<const std::uint8_t>(kept->second) : std::span<const std::uint8_t>();
  grid.storage = std::move(kept);
}

}  // namespace

DatasetParts partition_of(const Dataset& whole, const RegionTree& regions) {
  DatasetParts out;
  out.points = whole.grid.point_count();
  out.cells = whole.grid.cell_count();
  out.cell_types = whole.cell_types;
  out.bounds = whole.bounds;
  out.grid = whole.grid.kind_name();
  if (whole.grid.structured()) out.dims = whole.grid.dims();
  if (const auto* uniform = std::get_if<UniformGrid>(&whole.grid.shape)) out.origin = uniform->origin, out.spacing = uniform->spacing;
  for (const PointArray& array : whole.arrays) out.arrays.push_back({array.name, array.type, array.lower, array.upper, array.nan_count});
  out.regions = regions;
  return out;
}

fs::path manifest_of(const fs::path& list) { return fs::path(list).replace_extension(".parts.json"); }

std::string to_text(const DatasetParts& partition) {
  json::object root{{"format", 1}, {"points", partition.points}, {"cells", partition.cells}};
  root["cell_types"] = json::object(partition.cell_types.begin(), partition.cell_types.end());
  json::array bounds;
  for (int a = 0; a < 3; ++a) bounds.push_back(json::array{partition.bounds.lower[a], partition.bounds.upper[a]});
  root["bounds"] = std::move(bounds);
  root["grid"] = partition.grid;
  const bool structured = partition.grid != "unstructured";
  if (structured) root["dims"] = json_of(partition.dims);
  if (partition.grid == "uniform") root["origin"] = json_of(partition.origin), root["spacing"] = json_of(partition.spacing);
  json::array arrays, planes, parts;
  for (const DatasetParts::Array& of : partition.arrays)
    arrays.push_back(json::object{{"name", of.name}, {"type", to_string(of.type)}, {"range", of.lower <= of.upper ? json::value(json::array{of.lower, of.upper}) : json::value(nullptr)}, {"nan_count", of.nan_count}});
  for (const RegionTree::Node& of : partition.regions.nodes) planes.push_back(json::object{{"axis", of.axis}, {"at", of.at}, {"below", of.below}, {"above", of.above}});
  for (const DatasetParts::Part& of : partition.parts) {
    json::object part{{"file", of.file}};
    if (structured) part["first"] = json_of(of.first);
    part["points"] = of.points, part["cells"] = of.cells, part["own_cells"] = of.own_cells;
    parts.push_back(std::move(part));
  }
  root["arrays"] = std::move(arrays), root["planes"] = std::move(planes), root["parts"] = std::move(parts);
  return json::serialize(root) + "\n";
}

DatasetParts parse_partition(const std::string& text, const std::string& name) {
  const PartsReader reader(name);
  json::parse_options strict;
  strict.max_depth = 8;
  try {
    return read_manifest(reader.object(json::parse(text, {}, strict), "it"), reader);
  } catch (const boost::system::system_error& failure) {
    reader.refuse(std::string("is not well-formed JSON: ") + failure.what());
  }
}

std::optional<DatasetParts> find_partition(const fs::path& list) {
  const std::string ending = list.extension().string();
  if (ending != ".pvtu" && ending != ".pvti" && ending != ".pvtr" && ending != ".pvts") return std::nullopt;
  const fs::path path = manifest_of(list);
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  if (error) return std::nullopt;
  const std::string name = path.filename().string();
  if (bytes > kMostPartsFile) throw Error(ErrorCode::bad_data, name + ": " + std::to_string(bytes) + " bytes; expected at most " + std::to_string(kMostPartsFile));
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw Error(ErrorCode::bad_data, path.string() + ": cannot be read");
  return parse_partition(text, name);
}

std::shared_ptr<const Dataset> open_piece(const DatasetParts& partition, const fs::path& list, int region, const OpenOptions& options, const Task& task) {
  const DatasetParts::Part& part = partition.parts.at(static_cast<std::size_t>(region));
  const auto piece = open_unread((list.parent_path() / part.file).string(), options, task);
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::bad_data, part.file + ": " + what + "; expected what " + manifest_of(list).filename().string() + " says: write the partition anew");
  };
  if (piece->grid.point_count() != part.points || piece->grid.cell_count() != part.cells)
    refuse(std::to_string(piece->grid.point_count()) + " points and " + std::to_string(piece->grid.cell_count()) + " cells");
  if (piece->grid.kind_name() != partition.grid) refuse(std::string("a ") + piece->grid.kind_name() + " grid");
  if (piece->arrays.size() != partition.arrays.size()) refuse(std::to_string(piece->arrays.size()) + " arrays");
  if (piece->grid.structured())
    for (std::size_t a = 0; a < 3; ++a)
      if (part.first[a] + piece->grid.dims()[a] > partition.dims[a]) refuse("it reaches beyond the whole");
  auto made = std::make_shared<Dataset>(*piece);
  made->name = list.string();
  place_in_whole(partition, part, made->grid);
  show_ghosts(made->grid);
  for (std::size_t i = 0; i < made->arrays.size(); ++i) {
    PointArray& array = made->arrays[i];
    const DatasetParts::Array& of = partition.arrays[i];
    if (array.name != of.name || array.type != of.type) refuse("array '" + array.name + "' of " + to_string(array.type));
    array.lower = of.lower, array.upper = of.upper, array.nan_count = of.nan_count;
  }
  made->bounds = partition.bounds;
  made->cell_types = partition.cell_types;
  made->whole = std::make_shared<const WholeOfPart>(WholeOfPart{partition.points, partition.cells, partition.regions});
  return made;
}

}  // namespace isostrata
