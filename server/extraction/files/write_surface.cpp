#include "extraction/files/write_surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <limits>
#include <set>
#include <string>

#include "base/error.h"
#include "extraction/cells/structured_points.h"

namespace isostrata {
namespace {

static_assert(std::endian::native == std::endian::little,
              "formats are written in little-endian byte order as they lie in memory");

/// Calls visit for the chosen facets, in their order.
template <class Visit>
void visit_chosen(const IntervalMesh& mesh, std::span<const FacetChoice> choices, const Task& task, const Visit& visit) {
  std::size_t until_check = 0;
  for (const BoundaryFacet& facet : mesh.facets) {
    if (until_check-- == 0) {
      task.check();
      until_check = 1 << 14;
    }
    if (is_chosen(facet, choices)) visit(facet);
  }
}

/// The names of vertex properties: letters, digits and _, each once.
std::vector<std::string> property_names(std::span<const MeshArray> arrays) {
  std::set<std::string> taken{"x", "y", "z", "value"};
  std::vector<std::string> names;
  for (const MeshArray& array : arrays) {
    std::string name;
    for (const char c : array.name) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    if (name.empty()) name = "_";
    while (!taken.insert(name).second) name += "_";
    names.push_back(name);
  }
  return names;
}

}  // namespace

bool is_chosen(const BoundaryFacet& facet, std::span<const FacetChoice> choices) {
  return choices.empty() || std::any_of(choices.begin(), choices.end(), [&](const FacetChoice& choice) {
           return choice.label == facet.label && choice.interval.value_or(facet.interval) == facet.interval;
         });
}

void write_ply(OutputFile& out, const IntervalMesh& mesh, std::span<const MeshArray> more, std::span<const FacetChoice> choices,
               const Task& task) {
  RankedPoints used(static_cast<std::int64_t>(mesh.positions.size()));
  std::uint64_t faces = 0;
  visit_chosen(mesh, choices, task, [&](const BoundaryFacet& facet) {
    ++faces;
    for (const std::uint32_t p : facet.points) used.insert(p);
  });
  const std::uint32_t vertices = used.finish();
  const bool values = mesh.values.size() == mesh.positions.size();
  out.text("ply\nformat binary_little_endian 1.0\ncomment label: 0 lower, 1 upper, 2 domain\n");
  for (std::size_t i = 0; i < mesh.summaries.size(); ++i) {
    std::array<char, 100> line;
    std::snprintf(line.data(), line.size(), "comment interval %zu: %.17g %.17g\n", i, mesh.summaries[i].interval.lower,
                  mesh.summaries[i].interval.upper);
    out.text(line.data());
  }
  out.text("element vertex " + std::to_string(vertices) + "\nproperty double x\nproperty double y\nproperty double z\n");
  if (values) out.text("property double value\n");
  for (const std::string& name : property_names(more)) out.text("property float " + name + "\n");
  out.text("element face " + std::to_string(faces) +
           "\nproperty list uchar uint vertex_indices\nproperty ushort interval\nproperty uchar label\nend_header\n");
  const std::span<const std::uint64_t> words = used.words();
  for (std::size_t w = 0; w < words.size(); ++w) {
    if (w % 256 == 0) task.check();
    for (std::uint64_t rest = words[w]; rest; rest &= rest - 1) {
      const std::size_t p = 64 * w + static_cast<std::size_t>(std::countr_zero(rest));
      out.put(mesh.positions[p]);
      if (values) out.put(mesh.values[p]);
      for (const MeshArray& array : more) out.put(array.values[p]);
    }
  }
  visit_chosen(mesh, choices, task, [&](const BoundaryFacet& facet) {
    std::array<std::byte, 16> record;
    record[0] = std::byte{3};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t number = used.rank(facet.points[i]);
      std::memcpy(&record[1 + 4 * i], &number, 4);
    }
    std::memcpy(&record[13], &facet.interval, 2);
    record[15] = static_cast<std::byte>(facet.label);
    out.write(record);
  });
}

void write_stl(OutputFile& out, const IntervalMesh& mesh, std::span<const FacetChoice> choices, const Task& task) {
  std::uint64_t faces = 0;
  visit_chosen(mesh, choices, task, [&](const BoundaryFacet&) { ++faces; });
  if (faces > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::too_large,
                "STL holds at most 2^32 - 1 triangles; the boundary has " + std::to_string(faces) + ": write .ply");
  std::array<char, 80> header{};
  std::strncpy(header.data(), "interval boundary; attribute: 0 lower, 1 upper, 2 domain", header.size() - 1);
  out.put(header);
  out.put(static_cast<std::uint32_t>(faces));
  const auto single = [](Vec3d v) { return Vec3f{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; };
  visit_chosen(mesh, choices, task, [&](const BoundaryFacet& facet) {
    const Vec3d a = mesh.positions[facet.points[0]], b = mesh.positions[facet.points[1]], c = mesh.positions[facet.points[2]];
    const Vec3d n = cross(b - a, c - a);
    const double size = length(n);
    const std::array<Vec3f, 4> vectors{single(size > 0 ? n / size : Vec3d{}), single(a), single(b), single(c)};
    const auto label = static_cast<std::uint16_t>(facet.label);
    std::array<std::byte, 50> record;
    std::memcpy(record.data(), vectors.data(), 48);  // the normal is 0 if the triangle has no area
    std::memcpy(record.data() + 48, &label, 2);
    out.write(record);
  });
}

}  // namespace isostrata
