#include "extraction/write_mesh.h"

#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>

#include "base/error.h"

namespace isostrata {
namespace {

static_assert(std::endian::native == std::endian::little, "the formats are written in little-endian byte order as they lie in memory");

/// Writes values one by one through a buffer.
class ByteWriter {
 public:
  explicit ByteWriter(std::ostream& out) : out_(out) { buffer_.reserve(kBuffer); }
  ~ByteWriter() { flush(); }
  template <class T>
  void put(const T& value) {
    if (buffer_.size() + sizeof(T) > kBuffer) flush();
    const auto* bytes = reinterpret_cast<const char*>(&value);
    buffer_.insert(buffer_.end(), bytes, bytes + sizeof(T));
  }
  void flush() {
    out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    buffer_.clear();
  }

 private:
  static constexpr std::size_t kBuffer = 1 << 20;
  std::ostream& out_;
  std::vector<char> buffer_;
};

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 ? '_' : c;
    }
  }
  return out;
}

/// One <DataArray> and the bytes behind it.
struct Block {
  std::string type, name;
  int components = 1;
  std::uint64_t bytes = 0;
  std::function<void(ByteWriter&)> write;
};

template <class Value>
Block block(std::string type, std::string name, std::size_t count, int components, Value value) {
  using T = decltype(value(std::size_t{0}));
  return {std::move(type), std::move(name), components, static_cast<std::uint64_t>(count) * sizeof(T), [=](ByteWriter& out) {
            for (std::size_t i = 0; i < count; ++i) out.put(value(i));
          }};
}

void write_vtu(std::ostream& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more) {
  const std::size_t np = mesh.positions.size(), nt = mesh.tetrahedra.size();
  const auto of_interval = [&mesh](std::size_t t) -> const Interval& { return mesh.summaries[mesh.tetrahedron_interval[t]].interval; };

  struct Section {
    const char* tag;
    std::vector<Block> blocks;
  };
  std::vector<Section> sections;
  sections.push_back({"PointData", {}});
  sections.back().blocks.push_back(block("Float64", array_name, np, 1, [&mesh](std::size_t i) { return mesh.values[i]; }));
  for (const MeshArray& array : more)
    sections.back().blocks.push_back(block("Float32", array.name, np, 1, [&array](std::size_t i) { return array.values[i]; }));
  sections.push_back({"CellData", {}});
  sections.back().blocks.push_back(
      block("Int32", "interval", nt, 1, [&mesh](std::size_t t) { return std::int32_t{mesh.tetrahedron_interval[t]}; }));
  sections.back().blocks.push_back(block("Float64", "lower", nt, 1, [=](std::size_t t) { return of_interval(t).lower; }));
  sections.back().blocks.push_back(block("Float64", "upper", nt, 1, [=](std::size_t t) { return of_interval(t).upper; }));
  sections.push_back({"Points", {block("Float64", "Points", np, 3, [&mesh](std::size_t i) { return mesh.positions[i]; })}});
  constexpr std::uint8_t kVtkTetra = 10;
  sections.push_back(
      {"Cells",
       {block("Int64", "connectivity", 4 * nt, 1, [&mesh](std::size_t i) { return std::int64_t{mesh.tetrahedra[i / 4][i % 4]}; }),
        block("Int64", "offsets", nt, 1, [](std::size_t t) { return static_cast<std::int64_t>(4 * (t + 1)); }),
        block("UInt8", "types", nt, 1, [](std::size_t) { return kVtkTetra; })}});

  out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      << "  <UnstructuredGrid>\n    <Piece NumberOfPoints=\"" << np << "\" NumberOfCells=\"" << nt << "\">\n";
  std::uint64_t offset = 0;
  for (const Section& section : sections) {
    out << "      <" << section.tag;
    if (section.tag == std::string("PointData")) out << " Scalars=\"" << xml_text(array_name) << '"';
    out << ">\n";
    for (const Block& b : section.blocks) {
      out << "        <DataArray type=\"" << b.type << "\" Name=\"" << xml_text(b.name) << "\" NumberOfComponents=\"" << b.components
          << "\" format=\"appended\" offset=\"" << offset << "\"/>\n";
      offset += sizeof(std::uint64_t) + b.bytes;
    }
    out << "      </" << section.tag << ">\n";
  }
  out << "    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _";
  {
    ByteWriter writer(out);
    for (const Section& section : sections)
      for (const Block& b : section.blocks) {
        writer.put(b.bytes);
        b.write(writer);
      }
  }
  out << "\n  </AppendedData>\n</VTKFile>\n";
}

void write_ply(std::ostream& out, const IntervalMesh& mesh) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(mesh.positions.size(), kUnused);
  std::vector<std::uint32_t> used;  // mesh points of the boundary
  for (const BoundaryFacet& facet : mesh.facets)
    for (const std::uint32_t p : facet.points)
      if (number[p] == kUnused) {
        number[p] = static_cast<std::uint32_t>(used.size());
        used.push_back(p);
      }
  out << "ply\nformat binary_little_endian 1.0\ncomment label: 0 lower, 1 upper, 2 domain\nelement vertex " << used.size()
      << "\nproperty double x\nproperty double y\nproperty double z\nproperty double value\nelement face " << mesh.facets.size()
      << "\nproperty list uchar uint vertex_indices\nproperty ushort interval\nproperty uchar label\nend_header\n";
  ByteWriter writer(out);
  for (const std::uint32_t p : used) {
    writer.put(mesh.positions[p]);
    writer.put(mesh.values[p]);
  }
  for (const BoundaryFacet& facet : mesh.facets) {
    writer.put(std::uint8_t{3});
    for (const std::uint32_t p : facet.points) writer.put(number[p]);
    writer.put(facet.interval);
    writer.put(static_cast<std::uint8_t>(facet.label));
  }
}

void write_stl(std::ostream& out, const IntervalMesh& mesh) {
  std::array<char, 80> header{};
  std::strncpy(header.data(), "interval boundary; attribute: 0 lower, 1 upper, 2 domain", header.size() - 1);
  ByteWriter writer(out);
  writer.put(header);
  if (mesh.facets.size() > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::too_large, "STL holds at most 2^32 - 1 triangles; the boundary has " + std::to_string(mesh.facets.size()));
  writer.put(static_cast<std::uint32_t>(mesh.facets.size()));
  const auto single = [](Vec3d v) { return Vec3f{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; };
  for (const BoundaryFacet& facet : mesh.facets) {
    const Vec3d a = mesh.positions[facet.points[0]], b = mesh.positions[facet.points[1]], c = mesh.positions[facet.points[2]];
    const Vec3d n = cross(b - a, c - a);
    const double size = length(n);
    writer.put(single(size > 0 ? n / size : Vec3d{}));  // 0 where the triangle has no area
    writer.put(single(a));
    writer.put(single(b));
    writer.put(single(c));
    writer.put(static_cast<std::uint16_t>(facet.label));
  }
}

}  // namespace

void check_mesh_path(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (ending != ".vtu" && ending != ".ply" && ending != ".stl")
    throw Error(ErrorCode::unsupported, path.string() + ": unknown ending '" + ending + "'; expected .vtu, .ply or .stl");
}

void write_mesh(const std::filesystem::path& path, const IntervalMesh& mesh, const std::string& array_name,
                std::span<const MeshArray> more) {
  check_mesh_path(path);
  const std::string ending = path.extension().string();
  std::filesystem::path part = path;
  part += ".part";
  const auto fail = [&](const char* what) {
    const std::string reason = std::strerror(errno);
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    throw Error(ErrorCode::unavailable, path.string() + ": cannot " + what + ": " + reason);
  };
  errno = 0;
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  if (!out) fail("create");
  if (ending == ".vtu") write_vtu(out, mesh, array_name, more);
  if (ending == ".ply") write_ply(out, mesh);
  if (ending == ".stl") write_stl(out, mesh);
  out.close();
  if (!out) fail("write");
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) {
    errno = error.value();
    fail("rename");
  }
}

}  // namespace isostrata
