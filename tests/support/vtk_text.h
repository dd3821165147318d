// VTK's XML files as text, for tests that need a file of exactly these cells and arrays.
#pragma once

#include <array>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"

namespace isostrata::testing {

/// A <DataArray>. `type` is VTK's ("Float64", "UInt8", "Int64").
template <class T>
std::string data_array(const std::string& name, const std::string& type, const std::vector<T>& values, int components = 1) {
  std::ostringstream out;
  out.precision(17);
  out << "<DataArray Name=\"" << name << "\" type=\"" << type << "\" NumberOfComponents=\"" << components
      << "\" format=\"ascii\">";
  for (const T& value : values) out << ' ' << +value;
  out << "</DataArray>\n";
  return out.str();
}

inline std::string vtk_file(const std::string& type, const std::string& body) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
         "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n" + body + "</VTKFile>\n";
}

/// An unstructured grid that becomes a .vtu file.
struct VtuText {
  std::vector<Vec3d> points;
  std::vector<std::int64_t> connectivity, offsets;
  std::vector<int> types;
  std::vector<std::int64_t> faces, face_offsets;  // VTK's face stream; -1 for cells that are not polyhedra
  bool any_polyhedron = false;
  std::string point_arrays, cell_arrays;  // <DataArray> elements

  void add(int vtk_type, const std::vector<std::int64_t>& ids) {
    types.push_back(vtk_type);
    connectivity.insert(connectivity.end(), ids.begin(), ids.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    face_offsets.push_back(-1);
  }
  void add_polyhedron(const std::vector<std::vector<std::int64_t>>& cycles) {
    std::vector<std::int64_t> ids;
    faces.push_back(static_cast<std::int64_t>(cycles.size()));
    for (const auto& cycle : cycles) {
      faces.push_back(static_cast<std::int64_t>(cycle.size()));
      faces.insert(faces.end(), cycle.begin(), cycle.end());
      for (const std::int64_t id : cycle) {
        bool fresh = true;
        for (const std::int64_t known : ids) fresh = fresh && known != id;
        if (fresh) ids.push_back(id);
      }
    }
    add(42, ids);
    face_offsets.back() = static_cast<std::int64_t>(faces.size());
    any_polyhedron = true;
  }
  /// An array of one value per point or cell.
  template <class T>
  void point_array(const std::string& name, const std::string& type, const std::vector<T>& values) {
    point_arrays += data_array(name, type, values);
  }
  template <class T>
  void cell_array(const std::string& name, const std::string& type, const std::vector<T>& values) {
    cell_arrays += data_array(name, type, values);
  }

  std::string piece() const {
    std::vector<double> flat;
    for (const Vec3d& p : points) flat.insert(flat.end(), {p.x, p.y, p.z});
    std::string out = "<Piece NumberOfPoints=\"" + std::to_string(points.size()) + "\" NumberOfCells=\"" +
                      std::to_string(types.size()) + "\">\n<PointData>" + point_arrays + "</PointData><CellData>" + cell_arrays +
                      "</CellData>\n<Points>" + data_array("Points", "Float64", flat, 3) + "</Points>\n<Cells>" +
                      data_array("connectivity", "Int64", connectivity) + data_array("offsets", "Int64", offsets) +
                      data_array("types", "UInt8", types);
    if (any_polyhedron) out += data_array("faces", "Int64", faces) + data_array("faceoffsets", "Int64", face_offsets);
    return out + "</Cells>\n</Piece>\n";
  }
  std::string text() const { return vtk_file("UnstructuredGrid", "<UnstructuredGrid>\n" + piece() + "</UnstructuredGrid>\n"); }
};

/// A uniform grid of unit cells that becomes a .vti file. first: index of its first point.
inline std::string vti_text(std::array<int, 3> first, std::array<int, 3> points, const std::string& point_arrays,
                            const std::string& cell_arrays = "") {
  std::string extent;
  for (std::size_t a = 0; a < 3; ++a) extent += std::to_string(first[a]) + " " + std::to_string(first[a] + points[a] - 1) + " ";
  return vtk_file("ImageData", "<ImageData WholeExtent=\"" + extent + "\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\n<Piece Extent=\"" +
                                   extent + "\"><PointData>" + point_arrays + "</PointData><CellData>" + cell_arrays +
                                   "</CellData></Piece></ImageData>\n");
}

/// A rectilinear grid that becomes a .vtr file.
inline std::string vtr_text(const std::array<std::vector<double>, 3>& axes, const std::string& point_arrays,
                            const std::string& cell_arrays = "") {
  std::string extent, coordinates;
  for (std::size_t a = 0; a < 3; ++a) {
    extent += "0 " + std::to_string(axes[a].size() - 1) + " ";
    coordinates += data_array(std::string(1, "xyz"[a]), "Float64", axes[a]);
  }
  return vtk_file("RectilinearGrid", "<RectilinearGrid WholeExtent=\"" + extent + "\">\n<Piece Extent=\"" + extent +
                                         "\"><PointData>" + point_arrays + "</PointData><CellData>" + cell_arrays +
                                         "</CellData><Coordinates>" + coordinates + "</Coordinates></Piece></RectilinearGrid>\n");
}

/// A structured grid over these points that becomes a .vts file.
inline std::string vts_text(std::array<int, 3> dims, const std::vector<Vec3d>& points, const std::string& point_arrays,
                            const std::string& cell_arrays = "") {
  std::string extent;
  std::vector<double> flat;
  for (std::size_t a = 0; a < 3; ++a) extent += "0 " + std::to_string(dims[a] - 1) + " ";
  for (const Vec3d& p : points) flat.insert(flat.end(), {p.x, p.y, p.z});
  return vtk_file("StructuredGrid", "<StructuredGrid WholeExtent=\"" + extent + "\">\n<Piece Extent=\"" + extent +
                                        "\"><PointData>" + point_arrays + "</PointData><CellData>" + cell_arrays +
                                        "</CellData><Points>" + data_array("Points", "Float64", flat, 3) +
                                        "</Points></Piece></StructuredGrid>\n");
}

/// Points at whole numbers.
inline std::string vts_text(std::array<int, 3> dims, const std::string& point_arrays, const std::string& cell_arrays = "") {
  std::vector<Vec3d> points;
  for (int k = 0; k < dims[2]; ++k)
    for (int j = 0; j < dims[1]; ++j)
      for (int i = 0; i < dims[0]; ++i) points.push_back({double(i), double(j), double(k)});
  return vts_text(dims, points, point_arrays, cell_arrays);
}

/// A list of files, each with its time, that becomes a .pvd file.
inline std::string pvd_text(const std::vector<std::pair<double, std::string>>& steps) {
  std::ostringstream list;
  list.precision(17);
  for (const auto& [time, file] : steps) list << "<DataSet timestep=\"" << time << "\" file=\"" << file << "\"/>\n";
  return vtk_file("Collection", "<Collection>\n" + list.str() + "</Collection>\n");
}

}  // namespace isostrata::testing
