#include "import/read_mesh_in_place.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string_view>
#include <tuple>
#include <variant>

#include "import/appended_file.h"
#include "import/appended_xml.h"
#include "import/declared_time.h"
#include "import/for_parts.h"
#include "import/parsed_number.h"
#include "tables/cell_type.h"

namespace isostrata {
namespace {

constexpr std::size_t kReadTogether = 1u << 19;  // bytes, so that two of them fit the second cache

struct MeshArrays {
  FileArray points, types, ends, ids;
  std::vector<FileArray> values;
};

bool add_cells(const AppendedXml& xml, vtkXMLDataElement* cells, std::uint64_t count, MeshArrays& to) {
  vtkXMLDataElement* ids = nullptr;
  for (int i = 0; i < cells->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* const element = cells->GetNestedElement(i);
    const std::string_view name = attribute(element, "Name");
    if (name == "connectivity") {
      ids = element;
      continue;
    }
    auto array = xml.array(element, count);
    if (!array || array->components != 1 || (name != "offsets" && name != "types")) return false;
    (name == "types" ? to.types : to.ends) = std::move(*array);
  }
  const auto& ends = to.ends;
  const bool long_ends = ends.type == ScalarType::int64;
  if (!ids || ends.values.empty() || (!long_ends && ends.type != ScalarType::int32) || to.types.values.size() != count) return false;
  std::int64_t last = 0;
  std::int32_t short_last = 0;
  std::memcpy(long_ends ? static_cast<void*>(&last) : &short_last, ends.values.last(size_of(ends.type)).data(), size_of(ends.type));
  if (!long_ends) last = short_last;
  auto array = last >= 0 ? xml.array(ids, static_cast<std::uint64_t>(last)) : std::nullopt;
  if (!array || array->components != 1 || (array->type != ScalarType::int64 && array->type != ScalarType::int32)) return false;
  to.ids = std::move(*array);
  return true;
}

std::optional<MeshArrays> arrays_of(const AppendedXml& xml, vtkXMLDataElement* piece) {
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
      if (!array || array->components != 3 || (array->type != ScalarType::float32 && array->type != ScalarType::float64)) return std::nullopt;
      out.points = aligned(std::move(*array));
    } else {
      return std::nullopt;
    }
  }
  if (out.points.values.empty() || out.ids.values.empty()) return std::nullopt;
  return out;
}

/// Of each cell.
std::span<const std::uint8_t> types_of(const MeshArrays& arrays) {
  return {reinterpret_cast<const std::uint8_t*>(arrays.types.values.data()), arrays.types.values.size()};
}

/// Cells of the four kinds whose ids are all points; nothing for others.
bool set_cells(const MeshArrays& arrays, std::int64_t points, const ReadRequest& request, UnstructuredGrid& grid, std::vector<std::shared_ptr<const void>>& keep) {
  const std::span<const std::uint8_t> types = types_of(arrays);
  AppendedFile<std::int64_t> offsets(request, "offsets.bin"), connectivity(request, "connectivity.bin");
  offsets.add(std::array<std::int64_t, 1>{0});
  std::size_t cell = 0;
  std::int64_t last = 0;
  const bool ends_fit = for_parts(arrays.ends.type, arrays.ends.values, [&](std::span<const std::int64_t> ends) {
    for (const std::int64_t end : ends) {
      const std::uint8_t type = types[cell++];
      if (!holds_volume(type) || end - last != kPointsOfType[type]) return false;
      last = end;
    }
    offsets.add(ends);
    return true;
  });
  if (!ends_fit) return false;
  std::size_t done = 0;
  const std::size_t all = arrays.ids.values.size() / size_of(arrays.ids.type);
  const bool ids_fit = for_parts(arrays.ids.type, arrays.ids.values, [&](std::span<const std::int64_t> ids) {
    std::uint64_t largest = 0;  // a negative one is larger than all
    for (const std::int64_t id : ids) largest = std::max(largest, static_cast<std::uint64_t>(id));
    if (largest >= static_cast<std::uint64_t>(points)) return false;
    connectivity.add(ids);
    done += ids.size();
    request.progress(0.5 * static_cast<double>(done) / static_cast<double>(all));
    return true;
  });
  if (!ids_fit) return false;
  grid.types = types;
  keep.push_back(arrays.types.storage);
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

bool same_bytes(const FileArray& a, const FileArray& b) {
  if (a.type != b.type || a.values.size() != b.values.size()) return false;
  const auto here = MappedFile::place_of(a.values), there = MappedFile::place_of(b.values);
  return here && there ? same_in_files(*here, *there, a.values.size()) : std::memcmp(a.values.data(), b.values.data(), a.values.size()) == 0;
}

/// Whether the file that the caller has in memory holds the very same mesh, which is its grid as it is: VTK's reader divides other cells, about points that
/// no file has. Also no where that cannot be told.
bool is_like(const ReadRequest& request, const MeshArrays& arrays) {
  const auto types = types_of(arrays);
  if (request.like.empty() || !std::all_of(types.begin(), types.end(), [](std::uint8_t type) { return holds_volume(type); }) ||
      std::any_of(arrays.values.begin(), arrays.values.end(), [](const FileArray& array) { return array.on_cells; }))
    return false;
  try {
    const auto xml = AppendedXml::open(request.like);
    const auto mesh = xml ? xml->only_piece("UnstructuredGrid") : std::nullopt;
    const auto other = mesh ? arrays_of(*xml, mesh->piece) : std::nullopt;
    return other && same_bytes(arrays.types, other->types) && same_bytes(arrays.ends, other->ends) && same_bytes(arrays.ids, other->ids) &&
           same_bytes(arrays.points, other->points);
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

std::optional<Imported> vtu_in_place(const ReadRequest& request) {
  const auto xml = AppendedXml::open(request.file);
  const auto mesh = xml ? xml->only_piece("UnstructuredGrid") : std::nullopt;
  auto arrays = mesh ? arrays_of(*xml, mesh->piece) : std::nullopt;
  if (!arrays) return std::nullopt;
  check_step(request, 1);
  Imported imported;
  Block& block = imported.blocks.emplace_back();
  imported.times = {declared_time(request.file).value_or(0)};
  if (is_like(request, *arrays)) {
    block.like = true;
    block.arrays = std::move(arrays->values);
    return imported;
  }
  const std::uint64_t cells = arrays->types.values.size(), ids = arrays->ids.values.size() / size_of(arrays->ids.type);
  check_bytes(request, 9 * cells + 8 * ids + arrays->points.values.size(), request.file.filename().string());
  UnstructuredGrid grid;
  if (arrays->points.type == ScalarType::float32)
    grid.points = points_of<Vec3f>(arrays->points);
  else
    grid.points = points_of<Vec3d>(arrays->points);
  const auto keep = std::make_shared<std::vector<std::shared_ptr<const void>>>();
  const auto points = static_cast<std::int64_t>(std::visit([](auto span) { return span.size(); }, grid.points));
  if (!set_cells(*arrays, points, request, grid, *keep)) return std::nullopt;
  keep->push_back(arrays->points.storage);
  block.grid.shape = grid;
  block.grid.storage = keep;
  block.arrays = std::move(arrays->values);
  return imported;
}

}  // namespace isostrata
