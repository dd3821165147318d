#include "import/vtk/read_mesh_in_place.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string_view>
#include <tuple>
#include <variant>

#include "import/bytes/parsed_number.h"
#include "import/imported/appended_file.h"
#include "import/imported/declared_time.h"
#include "import/imported/for_parts.h"
#include "import/imported/xml_arrays.h"
#include "tables/cell_type.h"

namespace isostrata {
namespace {

constexpr std::size_t kReadTogether = 1u << 19;  // bytes, so that two of them fit the second cache

struct MeshArrays {
  XmlArray points, types, ends, ids;
  std::vector<XmlArray> values;
};

bool is_whole(const XmlArray& array) { return array.as.components == 1 && (array.as.type == ScalarType::int64 || array.as.type == ScalarType::int32); }

bool add_cells(const XmlArrays& xml, vtkXMLDataElement* cells, std::uint64_t count, MeshArrays& to) {
  bool all[3] = {};
  for (int i = 0; i < cells->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* const element = cells->GetNestedElement(i);
    const std::string_view name = attribute(element, "Name");
    const bool ids = name == "connectivity", types = name == "types";
    if (!ids && !types && name != "offsets") return false;
    auto array = ids ? xml.array(element) : xml.array(element, count);
    if (!array || array->as.components != 1 || (types ? size_of(array->as.type) != 1 : !is_whole(*array))) return false;
    all[ids ? 0 : types ? 1 : 2] = true;
    (ids ? to.ids : types ? to.types : to.ends) = std::move(*array);
  }
  return all[0] && all[1] && all[2];
}

std::optional<MeshArrays> arrays_of(const XmlArrays& xml, vtkXMLDataElement* piece) {
  const auto points = parsed_number<std::uint64_t>(attribute(piece, "NumberOfPoints")), cells = parsed_number<std::uint64_t>(attribute(piece, "NumberOfCells"));
  if (!points || !cells || *points == 0 || *cells == 0) return std::nullopt;
  MeshArrays out;
  for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* const part = piece->GetNestedElement(i);
    const std::string_view name = part->GetName();
    if (name == "PointData" || name == "CellData") {
      if (!xml.add_values(part, name == "CellData", name == "CellData" ? *cells : *points, out.values)) return std::nullopt;
    } else if (name == "Cells") {
      if (!add_cells(xml, part, *cells, out)) return std::nullopt;
    } else if (name == "Points" && part->GetNumberOfNestedElements() == 1) {
      auto array = xml.array(part->GetNestedElement(0), *points);
      if (!array || array->as.components != 3 || (array->as.type != ScalarType::float32 && array->as.type != ScalarType::float64)) return std::nullopt;
      out.points = std::move(*array);
    } else {
      return std::nullopt;
    }
  }
  if (out.points.coded.bytes == 0 || out.ids.coded.bytes == 0) return std::nullopt;
  return out;
}

/// Of each cell.
std::span<const std::uint8_t> types_of(const FileArray& array) { return {reinterpret_cast<const std::uint8_t*>(array.values.data()), array.values.size()}; }

/// Cells of the four kinds whose ids are all points; nothing for others.
bool set_cells(const FileArray& of_types, const FileArray& ends, const FileArray& ids, std::int64_t points, const ReadRequest& request, UnstructuredGrid& grid,
               std::vector<std::shared_ptr<const void>>& keep) {
  const std::span<const std::uint8_t> types = types_of(of_types);
  const std::size_t all = ids.values.size() / size_of(ids.type);
  AppendedFile<std::int64_t> offsets(request, "offsets.bin"), connectivity(request, "connectivity.bin");
  offsets.add(std::array<std::int64_t, 1>{0});
  std::size_t cell = 0;
  std::int64_t last = 0;
  const bool ends_fit = for_parts(ends.type, ends.values, [&](std::span<const std::int64_t> part) {
    for (const std::int64_t end : part) {
      const std::uint8_t type = types[cell++];
      if (!holds_volume(type) || end - last != kPointsOfType[type]) return false;
      last = end;
    }
    offsets.add(part);
    return true;
  });
  if (!ends_fit || static_cast<std::uint64_t>(last) != all) return false;
  std::size_t done = 0;
  const bool ids_fit = for_parts(ids.type, ids.values, [&](std::span<const std::int64_t> part) {
    std::uint64_t largest = 0;  // a negative one is larger than all
    for (const std::int64_t id : part) largest = std::max(largest, static_cast<std::uint64_t>(id));
    if (largest >= static_cast<std::uint64_t>(points)) return false;
    connectivity.add(part);
    done += part.size();
    request.progress(0.5 * static_cast<double>(done) / static_cast<double>(all));
    return true;
  });
  if (!ids_fit) return false;
  grid.types = types;
  keep.push_back(of_types.storage);
  std::tie(grid.offsets, keep.emplace_back()) = offsets.finish();
  std::tie(grid.connectivity, keep.emplace_back()) = connectivity.finish();
  return true;
}

template <class Point>
std::span<const Point> points_of(const FileArray& array) {
  return {reinterpret_cast<const Point*>(array.values.data()), array.values.size() / sizeof(Point)};
}

/// Read past the mapping: the kernel copies whole files at the memory's rate, and pages that are mapped to be looked at once cost more than that.
bool same_in_files(const FilePlace& a, const FilePlace& b, std::size_t bytes) {
  std::ifstream one(a.file, std::ios::binary), other(b.file, std::ios::binary);
  one.seekg(static_cast<std::streamoff>(a.offset));
  other.seekg(static_cast<std::streamoff>(b.offset));
  std::vector<char> left(std::min(bytes, kReadTogether)), right(left.size());
  for (std::size_t at = 0; at < bytes; at += left.size()) {
    const auto count = static_cast<std::streamsize>(std::min(left.size(), bytes - at));
    if (!one.read(left.data(), count) || !other.read(right.data(), count) || std::memcmp(left.data(), right.data(), static_cast<std::size_t>(count)) != 0) return false;
  }
  return true;
}

/// As they stand: what is coded otherwise counts as something else.
bool same_values(const XmlArray& a, const XmlArray& b) {
  if (a.as.type != b.as.type || a.coded.coding != b.coded.coding || a.coded.text.size() != b.coded.text.size()) return false;
  const auto here = MappedFile::place_of(a.coded.text), there = MappedFile::place_of(b.coded.text);
  return here && there && same_in_files(*here, *there, a.coded.text.size());
}

/// Whether the file that the caller has in memory holds the very same mesh, which is its grid as it is: VTK's reader divides other cells, about points that
/// no file has. Also no if that cannot be told.
bool is_like(const ReadRequest& request, const MeshArrays& arrays) {
  if (request.like.empty() || std::any_of(arrays.values.begin(), arrays.values.end(), [](const XmlArray& array) { return array.as.on_cells; })) return false;
  try {
    const auto xml = XmlArrays::open(request.like);
    const auto mesh = xml ? xml->only_piece("UnstructuredGrid") : std::nullopt;
    const auto other = mesh ? arrays_of(*xml, mesh->piece) : std::nullopt;
    return other && same_values(arrays.types, other->types) && same_values(arrays.ends, other->ends) && same_values(arrays.ids, other->ids) &&
           same_values(arrays.points, other->points);
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

std::optional<Imported> vtu_in_place(const ReadRequest& request) {
  const auto xml = XmlArrays::open(request.file);
  const auto mesh = xml ? xml->only_piece("UnstructuredGrid") : std::nullopt;
  const auto arrays = mesh ? arrays_of(*xml, mesh->piece) : std::nullopt;
  if (!arrays) return std::nullopt;
  check_step(request, 1);
  Imported imported;
  Block& block = imported.blocks.emplace_back();
  imported.times = {declared_time(request.file).value_or(0)};
  const std::uint64_t cells = arrays->types.coded.bytes, ids = arrays->ids.coded.bytes / size_of(arrays->ids.as.type);
  check_bytes(request, 9 * cells + 8 * ids + arrays->points.coded.bytes + decoded_bytes(arrays->values), request.file.filename().string());
  const auto types = decoded(arrays->types);  // before all else: where a cell is of another kind, nothing else is of use
  const auto kinds = types ? types_of(*types) : std::span<const std::uint8_t>();
  if (kinds.empty() || !std::all_of(kinds.begin(), kinds.end(), [](std::uint8_t type) { return holds_volume(type); })) return std::nullopt;
  block.like = is_like(request, *arrays);
  if (!block.like) {
    const auto ends = decoded(arrays->ends), all_ids = decoded(arrays->ids);
    auto places = decoded(arrays->points);
    if (!ends || !all_ids || !places) return std::nullopt;
    const FileArray points = aligned(std::move(*places));
    UnstructuredGrid grid;
    if (points.type == ScalarType::float32)
      grid.points = points_of<Vec3f>(points);
    else
      grid.points = points_of<Vec3d>(points);
    const auto keep = std::make_shared<std::vector<std::shared_ptr<const void>>>();
    const auto count = static_cast<std::int64_t>(std::visit([](auto span) { return span.size(); }, grid.points));
    if (!set_cells(*types, *ends, *all_ids, count, request, grid, *keep)) return std::nullopt;
    keep->push_back(points.storage);
    block.grid.shape = grid;
    block.grid.storage = keep;
  }
  auto values = decoded(arrays->values);
  if (!values) return std::nullopt;
  block.arrays = std::move(*values);
  return imported;
}

}  // namespace isostrata
