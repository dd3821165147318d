// Interval meshes as files that other programs open.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/task.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Boundary facets with a label, of all intervals or of one.
struct FacetChoice {
  FacetLabel label = FacetLabel::domain;
  std::optional<std::uint16_t> interval;  // its number in the request; empty: any

  bool operator==(const FacetChoice&) const = default;
};

struct WriteOptions {
  /// .vtu: zlib's level, 1 to 9; 0 writes the arrays as they are. Level 1 is the default: on torus:256 it makes the file a
  /// seventh as long, and level 6 takes three times as long for a few per cent more.
  int compression = 1;
  std::vector<FacetChoice> facets;  // .ply and .stl: those that match any; empty: all
};

/// Throws unsupported if write_mesh knows no format for the path's ending: for asking before the work is done.
void check_mesh_path(const std::filesystem::path& path);

/// Writes by the ending of the path's name:
///   .vtu  VTK's XML UnstructuredGrid, binary (raw appended data, 64-bit sizes), compressed by vtkZLibDataCompressor's rules:
///         tetrahedra with cell arrays `interval` (0, 1, ... in the order of the request), `lower` and `upper`, the extracted
///         values as a point array `array_name` where the mesh has them, and `more` point or cell arrays;
///   .vtkhdf  the same as VTKHDF 1.0, never compressed: for large meshes, which it takes as fast as the disk does;
///   .ply  the boundary facets, binary, with `interval` and `label` (0 lower, 1 upper, 2 domain) for each face; vertices have the
///         extracted values as `value`, and those of `more` that are at points, letters outside [A-Za-z0-9_] in their names made _;
///   .stl  the boundary facets, binary, the label in the attribute bytes.
/// Nothing of the mesh is copied whole: blocks of a few megabytes are made, compressed on the pool and written; .ply needs 1.5
/// bits more for each mesh point. The file is complete or not there: it is written beside the path and renamed. Precondition for
/// .ply and .stl: extracted with facets. Throws unsupported (another ending), unavailable (cannot write, and the system's
/// reason), too_large (more facets than STL counts), cancelled.
void write_mesh(const std::filesystem::path& path, const IntervalMesh& mesh, const std::string& array_name,
                std::span<const MeshArray> more, const WriteOptions& options, const Task& task);

}  // namespace isostrata
