#include "extraction/files/write_vtu.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"

namespace isostrata {
namespace {

static_assert(std::endian::native == std::endian::little,
              "formats are written in little-endian byte order as they lie in memory");

constexpr std::uint64_t kBlockBytes = 256 << 10;
constexpr std::uint64_t kBlocksAtATime = 32;

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 ? '_' : c;
    }
  }
  return out;
}

/// Of a flat grid the facets are what was cut.
bool has_areas(const IntervalMesh& mesh) { return mesh.tetrahedra.empty() && !mesh.facets.empty(); }

std::uint64_t simplex_count(const IntervalMesh& mesh) { return has_areas(mesh) ? mesh.facets.size() : mesh.tetrahedra.size(); }

/// value(i) for item i.
template <class Value>
VtuArray array_of(std::string type, std::string name, std::uint64_t count, int components, Value value) {
  using Item = decltype(value(std::uint64_t{0}));
  return {std::move(type),
          std::move(name),
          components,
          count,
          sizeof(Item),
          [value](std::uint64_t first, std::uint64_t last, std::byte* to) {
            for (std::uint64_t i = first; i < last; ++i, to += sizeof(Item)) {
              const Item item = value(i);
              std::memcpy(to, &item, sizeof item);
            }
          }};
}

struct Section {
  const char* tag;
  std::vector<VtuArray> arrays;
};

/// Indices in the narrowest type that holds them; both arrays in the same one. points(i) has the kCorners points of simplex i.
template <class Index, std::size_t kCorners, class Points>
std::vector<VtuArray> cells_of(std::uint64_t count, const char* type, std::uint8_t vtk_type, const Points& points) {
  return {array_of(type, "connectivity", count, 1,
                   [points](std::uint64_t i) {
                     std::array<Index, kCorners> out;
                     for (std::size_t v = 0; v < kCorners; ++v) out[v] = static_cast<Index>(points(i)[v]);
                     return out;
                   }),
          array_of(type, "offsets", count, 1, [](std::uint64_t i) { return static_cast<Index>(kCorners * (i + 1)); }),
          array_of("UInt8", "types", count, 1, [vtk_type](std::uint64_t) { return vtk_type; })};
}

template <class Index>
std::vector<VtuArray> simplices_of(const IntervalMesh& mesh, const char* type) {
  if (has_areas(mesh))
    return cells_of<Index, 3>(mesh.facets.size(), type, 5, [&mesh](std::uint64_t i) { return mesh.facets[i].points; });
  return cells_of<Index, 4>(mesh.tetrahedra.size(), type, 10, [&mesh](std::uint64_t i) { return mesh.tetrahedra[i]; });
}

std::vector<Section> sections_of(const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more) {
  const std::uint64_t np = mesh.positions.size(), nt = simplex_count(mesh);
  std::vector<Section> sections{{"PointData", {}}, {"CellData", {}}, {"Points", {}}, {"Cells", {}}};
  if (mesh.values.size() == np)
    sections[0].arrays.push_back(array_of("Float64", array_name, np, 1, [&mesh](std::uint64_t i) { return mesh.values[i]; }));
  for (const MeshArray& array : more)
    sections[0].arrays.push_back(array_of("Float32", array.name, np, 1, [&array](std::uint64_t i) { return array.values[i]; }));
  const bool areas = has_areas(mesh);
  const auto number = [&mesh, areas](std::uint64_t t) { return areas ? mesh.facets[t].interval : mesh.tetrahedron_interval[t]; };
  const auto of_interval = [&mesh, number](std::uint64_t t) -> const Interval& { return mesh.summaries[number(t)].interval; };
  sections[1].arrays.push_back(
      array_of("Int32", "interval", nt, 1, [=](std::uint64_t t) { return std::int32_t{number(t)}; }));
  sections[1].arrays.push_back(array_of("Float64", "lower", nt, 1, [=](std::uint64_t t) { return of_interval(t).lower; }));
  sections[1].arrays.push_back(array_of("Float64", "upper", nt, 1, [=](std::uint64_t t) { return of_interval(t).upper; }));
  sections[2].arrays.push_back(array_of("Float64", "Points", np, 3, [&mesh](std::uint64_t i) { return mesh.positions[i]; }));
  constexpr std::uint64_t kInt32 = std::numeric_limits<std::int32_t>::max();
  sections[3].arrays =
      np <= kInt32 && 4 * nt <= kInt32 ? simplices_of<std::int32_t>(mesh, "Int32") : simplices_of<std::int64_t>(mesh, "Int64");
  return sections;
}

void compress_block(const std::vector<std::byte>& from, int level, std::vector<std::byte>& to) {
  auto size = static_cast<uLongf>(compressBound(static_cast<uLong>(from.size())));
  to.resize(size);
  const int status = compress2(reinterpret_cast<Bytef*>(to.data()), &size, reinterpret_cast<const Bytef*>(from.data()),
                               static_cast<uLong>(from.size()), level);
  if (status != Z_OK) throw Error(ErrorCode::internal, "zlib: compress2 returned " + std::to_string(status));
  to.resize(size);
}

}  // namespace

void write_appended(OutputFile& out, const VtuArray& array, int compression, const Task& task) {
  const std::uint64_t per_block = std::max<std::uint64_t>(1, kBlockBytes / array.item_bytes);
  const std::uint64_t blocks = (array.count + per_block - 1) / per_block;
  const std::uint64_t begin = out.size();
  std::vector<std::uint64_t> table;
  if (compression == 0) {
    out.put(array.count * array.item_bytes);
  } else {
    table.assign(3 + blocks, 0);
    table[0] = blocks;
    table[1] = per_block * array.item_bytes;
    table[2] = array.count % per_block * array.item_bytes;
    out.write(std::as_bytes(std::span(table)));  // the sizes are filled in afterwards
  }
  std::array<std::vector<std::byte>, kBlocksAtATime> plain, packed;
  for (std::uint64_t first = 0; first < blocks; first += kBlocksAtATime) {
    const std::uint64_t count = std::min(kBlocksAtATime, blocks - first);
    parallel_for(static_cast<std::int64_t>(count), 1, [&](std::int64_t from, std::int64_t to) {
      for (std::int64_t b = from; b < to; ++b) {
        task.check();
        const std::uint64_t item = (first + static_cast<std::uint64_t>(b)) * per_block;
        const std::uint64_t last = std::min(array.count, item + per_block);
        plain[b].resize((last - item) * array.item_bytes);
        array.fill(item, last, plain[b].data());
        if (compression != 0) compress_block(plain[b], compression, packed[b]);
      }
    });
    for (std::uint64_t b = 0; b < count; ++b) {
      out.write(compression == 0 ? plain[b] : packed[b]);
      if (compression != 0) table[3 + first + b] = packed[b].size();
    }
  }
  if (compression != 0) out.patch(begin, std::as_bytes(std::span(table)));
}

void write_vtu(OutputFile& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more,
               int compression, const Task& task) {
  const std::vector<Section> sections = sections_of(mesh, array_name, more);
  out.text(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\"");
  if (compression != 0) out.text(" compressor=\"vtkZLibDataCompressor\"");
  out.text(">\n  <UnstructuredGrid>\n    <Piece NumberOfPoints=\"" + std::to_string(mesh.positions.size()) +
           "\" NumberOfCells=\"" + std::to_string(simplex_count(mesh)) + "\">\n");
  std::vector<std::uint64_t> offset_at;  // where each array's offset stands, filled in once it is known
  const std::string room(21, ' ');       // for 20 digits and the closing quote
  for (const Section& section : sections) {
    out.text(std::string("      <") + section.tag);
    if (section.tag == std::string("PointData") && !section.arrays.empty())
      out.text(" Scalars=\"" + xml_text(section.arrays.front().name) + "\"");
    out.text(">\n");
    for (const VtuArray& array : section.arrays) {
      out.text("        <DataArray type=\"" + array.type + "\" Name=\"" + xml_text(array.name) + "\" NumberOfComponents=\"" +
               std::to_string(array.components) + "\" format=\"appended\" offset=\"");
      offset_at.push_back(out.size());
      out.text(room + "/>\n");
    }
    out.text(std::string("      </") + section.tag + ">\n");
  }
  out.text("    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _");
  const std::uint64_t base = out.size();
  auto at = offset_at.begin();
  for (const Section& section : sections)
    for (const VtuArray& array : section.arrays) {
      const std::string offset = std::to_string(out.size() - base) + "\"";
      out.patch(*at++, std::as_bytes(std::span(offset)));
      write_appended(out, array, compression, task);
    }
  out.text("\n  </AppendedData>\n</VTKFile>\n");
}

void write_pvtu(OutputFile& out, std::span<const std::string> pieces, const std::string& array_name, std::span<const std::string> more) {
  const auto array = [&](const char* type, const std::string& name, const char* rest = "") {
    out.text("      <PDataArray type=\"" + std::string(type) + "\" Name=\"" + xml_text(name) + "\"" + rest + "/>\n");
  };
  out.text("<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
           "  <PUnstructuredGrid GhostLevel=\"0\">\n    <PPoints>\n");
  array("Float64", "Points", " NumberOfComponents=\"3\"");
  out.text("    </PPoints>\n    <PCellData>\n");
  array("Int32", "interval");
  for (const char* end : {"lower", "upper"}) array("Float64", end);
  out.text("    </PCellData>\n    <PPointData>\n");
  if (!array_name.empty()) array("Float64", array_name);
  for (const std::string& name : more) array("Float32", name);
  out.text("    </PPointData>\n");
  for (const std::string& piece : pieces) out.text("    <Piece Source=\"" + xml_text(piece) + "\"/>\n");
  out.text("  </PUnstructuredGrid>\n</VTKFile>\n");
}

}  // namespace isostrata
