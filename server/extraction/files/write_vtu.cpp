#include "extraction/files/write_vtu.h"

#include <array>
#include <limits>

#include "extraction/files/vtk_xml.h"

namespace isostrata {
namespace {

/// Of a flat grid the facets are what was cut.
bool has_areas(const IntervalMesh& mesh) { return mesh.tetrahedra.empty() && !mesh.facets.empty(); }

std::uint64_t simplex_count(const IntervalMesh& mesh) { return has_areas(mesh) ? mesh.facets.size() : mesh.tetrahedra.size(); }

/// Indices in the narrowest type that holds them; both arrays in the same one. points(i) has the kCorners points of simplex i.
template <class Index, std::size_t kCorners, class Points>
std::vector<VtkArray> cells_of(std::uint64_t count, const char* type, std::uint8_t vtk_type, const Points& points) {
  return {vtk_array(type, "connectivity", count, 1,
                   [points](std::uint64_t i) {
                     std::array<Index, kCorners> out;
                     for (std::size_t v = 0; v < kCorners; ++v) out[v] = static_cast<Index>(points(i)[v]);
                     return out;
                   }),
          vtk_array(type, "offsets", count, 1, [](std::uint64_t i) { return static_cast<Index>(kCorners * (i + 1)); }),
          vtk_array("UInt8", "types", count, 1, [vtk_type](std::uint64_t) { return vtk_type; })};
}

template <class Index>
std::vector<VtkArray> simplices_of(const IntervalMesh& mesh, const char* type) {
  if (has_areas(mesh))
    return cells_of<Index, 3>(mesh.facets.size(), type, 5, [&mesh](std::uint64_t i) { return mesh.facets[i].points; });
  return cells_of<Index, 4>(mesh.tetrahedra.size(), type, 10, [&mesh](std::uint64_t i) { return mesh.tetrahedra[i]; });
}

/// Also of no areas at all.
std::vector<VtkArray> simplices_of_areas(const IntervalMesh& mesh) {
  return cells_of<std::int64_t, 3>(mesh.facets.size(), "Int64", 5, [&mesh](std::uint64_t i) { return mesh.facets[i].points; });
}

}  // namespace

std::vector<VtkSection> mesh_sections(const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more) {
  const std::uint64_t np = mesh.positions.size(), nt = simplex_count(mesh);
  std::vector<VtkSection> sections{{"PointData", {}, ""}, {"CellData", {}, ""}, {"Points", {}, ""}, {"Cells", {}, ""}};
  if (mesh.values.size() == np)
    sections[0].arrays.push_back(vtk_array("Float64", array_name, np, 1, [&mesh](std::uint64_t i) { return mesh.values[i]; }));
  for (const MeshArray& array : more)
    sections[array.in_cells ? 1 : 0].arrays.push_back(
        vtk_array("Float32", array.name, array.in_cells ? nt : np, 1, [&array](std::uint64_t i) { return array.values[i]; }));
  const bool areas = has_areas(mesh);
  const auto number = [&mesh, areas](std::uint64_t t) { return areas ? mesh.facets[t].interval : mesh.tetrahedron_interval[t]; };
  const auto of_interval = [&mesh, number](std::uint64_t t) -> const Interval& { return mesh.summaries[number(t)].interval; };
  sections[1].arrays.push_back(
      vtk_array("Int32", "interval", nt, 1, [=](std::uint64_t t) { return std::int32_t{number(t)}; }));
  sections[1].arrays.push_back(vtk_array("Float64", "lower", nt, 1, [=](std::uint64_t t) { return of_interval(t).lower; }));
  sections[1].arrays.push_back(vtk_array("Float64", "upper", nt, 1, [=](std::uint64_t t) { return of_interval(t).upper; }));
  sections[2].arrays.push_back(vtk_array("Float64", "Points", np, 3, [&mesh](std::uint64_t i) { return mesh.positions[i]; }));
  constexpr std::uint64_t kInt32 = std::numeric_limits<std::int32_t>::max();
  sections[3].arrays =
      np <= kInt32 && 4 * nt <= kInt32 ? simplices_of<std::int32_t>(mesh, "Int32") : simplices_of<std::int64_t>(mesh, "Int64");
  return sections;
}

void write_vtu(OutputFile& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more,
               int compression, const Task& task) {
  VtkXml file{"UnstructuredGrid", "",
              " NumberOfPoints=\"" + std::to_string(mesh.positions.size()) + "\" NumberOfCells=\"" + std::to_string(simplex_count(mesh)) + "\"",
              mesh_sections(mesh, array_name, more)};
  VtkSection& on_points = file.sections.front();
  if (!on_points.arrays.empty()) on_points.attributes = " Scalars=\"" + xml_text(on_points.arrays.front().name) + "\"";
  write_vtk_xml(out, file, compression, task);
}

void write_vtp(OutputFile& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more, int compression, const Task& task) {
  VtkXml file{"PolyData", "", " NumberOfPoints=\"" + std::to_string(mesh.positions.size()) + "\" NumberOfPolys=\"" + std::to_string(mesh.facets.size()) + "\"",
              mesh_sections(mesh, array_name, more)};
  VtkSection& polygons = file.sections.back();
  polygons.tag = "Polys";
  polygons.arrays = simplices_of_areas(mesh);
  polygons.arrays.pop_back();  // the types
  write_vtk_xml(out, file, compression, task);
}

void write_pvtu(OutputFile& out, std::span<const std::string> pieces, const std::string& array_name, std::span<const std::string> more) {
  VtkXml file{"UnstructuredGrid", " GhostLevel=\"0\"", "", {{"PointData", {}, ""}, {"CellData", {}, ""}, {"Points", {}, ""}}};
  const auto add = [&](std::size_t section, const char* type, const std::string& name, int components = 1) {
    file.sections[section].arrays.push_back({.type = type, .name = name, .components = components});
  };
  if (!array_name.empty()) add(0, "Float64", array_name);
  for (const std::string& name : more) add(0, "Float32", name);
  add(1, "Int32", "interval");
  for (const char* end : {"lower", "upper"}) add(1, "Float64", end);
  add(2, "Float64", "Points", 3);
  std::vector<std::string> places;
  for (const std::string& piece : pieces) places.push_back(" Source=\"" + xml_text(piece) + "\"");
  write_vtk_list(out, file, places);
}

}  // namespace isostrata
