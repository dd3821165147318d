#include "extraction/files/write_part.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>

#include "data/parts/partition.h"
#include "extraction/files/vtk_xml.h"

namespace isostrata {
namespace {

std::string exact(double value) {
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string three(const Vec3d& v) { return exact(v.x) + " " + exact(v.y) + " " + exact(v.z); }

std::string extent(const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims) {
  std::string out;
  for (std::size_t a = 0; a < 3; ++a) out += (a == 0 ? "" : " ") + std::to_string(first[a]) + " " + std::to_string(first[a] + dims[a] - 1);
  return out;
}

/// "uint8" -> "UInt8".
std::string vtk_name(ScalarType type) {
  std::string name = to_string(type);
  const std::size_t letters = name.starts_with('u') ? 2 : 1;
  for (std::size_t i = 0; i < letters; ++i) name[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[i])));
  return name;
}

template <class T>
VtkArray copied(std::string type, std::string name, std::span<const T> values, int components = 1) {
  const std::uint64_t item = sizeof(T) * static_cast<std::uint64_t>(components);
  return {std::move(type), std::move(name), components, values.size() / static_cast<std::size_t>(components), item,
          [values, item](std::uint64_t first, std::uint64_t last, std::byte* to) {
            std::memcpy(to, std::as_bytes(values).data() + first * item, (last - first) * item);
          }};
}

VtkArray array_of_points(const PointArray& array) {
  VtkArray out = std::visit([&](auto values) { return copied(vtk_name(array.type), array.name, values); }, array.values);
  out.unit = array.unit;
  return out;
}

VtkArray positions(const PointSpan& points) {
  return std::visit(
      [](auto all) {
        using V = std::remove_const_t<typename decltype(all)::element_type>;
        return vtk_array(sizeof(V) == sizeof(Vec3f) ? "Float32" : "Float64", "Points", all.size(), 3, [all](std::uint64_t i) { return all[i]; });
      },
      points);
}

constexpr std::uint8_t kDuplicate = 1, kHidden = 32;  // vtkDataSetAttributes

/// owned: empty if margins are not marked.
VtkArray marks(const Grid& grid, std::span<const std::uint8_t> owned) {
  return vtk_array("UInt8", "vtkGhostType", static_cast<std::uint64_t>(grid.cell_count()), 1, [&grid, owned](std::uint64_t c) {
    const bool hidden = grid.hidden(static_cast<std::int64_t>(c)), ghost = !owned.empty() && owned[c] == 0;
    return static_cast<std::uint8_t>((hidden ? kHidden : 0) | (ghost ? kDuplicate : 0));
  });
}

/// The type, the attributes that list and pieces share, and the sections of a part; a list looks at no values.
VtkXml file_of(const Dataset& whole, const Dataset& part, const PartOrigin& origin, std::span<const std::uint8_t> owned) {
  const Grid& grid = part.grid;
  VtkXml file{"", "", "", {{"PointData", {}, ""}, {"CellData", {}, ""}}};
  for (const PointArray& array : part.arrays) file.sections[0].arrays.push_back(array_of_points(array));
  if (whole.grid.structured()) {
    if (!whole.grid.hidden_cells.empty()) file.sections[1].arrays.push_back(marks(grid, {}));
    if (const auto* uniform = std::get_if<UniformGrid>(&whole.grid.shape)) {
      file.type = "ImageData";
      file.attributes = " Origin=\"" + three(uniform->origin) + "\" Spacing=\"" + three(uniform->spacing) + "\"";
    } else if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&grid.shape)) {
      file.type = "StructuredGrid";
      file.sections.push_back({"Points", {positions(curvilinear->points)}, ""});
    } else {
      file.type = "RectilinearGrid";
      VtkSection axes{"Coordinates", {}, ""};
      const char* const names[3] = {"x", "y", "z"};
      for (std::size_t a = 0; a < 3; ++a) axes.arrays.push_back(copied("Float64", names[a], std::span<const double>(std::get<RectilinearGrid>(grid.shape).axes[a])));
      file.sections.push_back(std::move(axes));
    }
    return file;
  }
  const auto& cells = std::get<UnstructuredGrid>(grid.shape);
  file.type = "UnstructuredGrid";
  file.sections[0].arrays.push_back(copied("Int64", kGlobalPoints, std::span<const std::int64_t>(origin.points)));
  file.sections[0].attributes = std::string(" GlobalIds=\"") + kGlobalPoints + "\"";
  file.sections[1].arrays.push_back(marks(grid, owned));
  file.sections.push_back({"Points", {positions(cells.points)}, ""});
  file.sections.push_back({"Cells",
                           {copied("Int64", "connectivity", cells.connectivity), copied("Int64", "offsets", cells.offsets.subspan(1)), copied("UInt8", "types", cells.types)},
                           ""});
  return file;
}

}  // namespace

PartEndings part_endings(const Grid& whole) {
  static constexpr const char* kLetters[] = {"i", "r", "s", "u"};  // in the order of Grid::shape
  const std::string letter = kLetters[whole.shape.index()];
  return {".pvt" + letter, ".vt" + letter};
}

WrittenPart write_part(const std::filesystem::path& path, const Dataset& whole, const Dataset& part, const PartOrigin& origin, std::span<const std::uint8_t> owned,
                       const Task& task) {
  VtkXml file = file_of(whole, part, origin, owned);
  WrittenPart written{path.filename().string(), {}, {}};
  if (whole.grid.structured()) {
    written.first = origin.box.from, written.dims = origin.box.dims;
    const std::string own = extent(written.first, written.dims);
    file.attributes = " WholeExtent=\"" + own + "\"" + file.attributes;
    file.piece = " Extent=\"" + own + "\"";
  } else {
    file.piece = " NumberOfPoints=\"" + std::to_string(part.grid.point_count()) + "\" NumberOfCells=\"" + std::to_string(part.grid.cell_count()) + "\"";
  }
  OutputFile out(path);
  write_vtk_xml(out, file, 0, task);
  out.finish();
  return written;
}

void write_part_list(const std::filesystem::path& path, const Dataset& whole, std::span<const WrittenPart> parts) {
  VtkXml file = file_of(whole, whole, {}, {});
  file.attributes = (whole.grid.structured() ? " WholeExtent=\"" + extent({}, whole.grid.dims()) + "\"" : "") + std::string(" GhostLevel=\"1\"") + file.attributes;
  std::vector<std::string> pieces;
  for (const WrittenPart& part : parts)
    pieces.push_back((whole.grid.structured() ? " Extent=\"" + extent(part.first, part.dims) + "\"" : "") + std::string(" Source=\"") + xml_text(part.file) + "\"");
  OutputFile out(path);
  write_vtk_list(out, file, pieces);
  out.finish();
}

}  // namespace isostrata
