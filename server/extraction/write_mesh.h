// Interval meshes as files that other programs open.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "extraction/interval_mesh.h"

namespace isostrata {

/// Throws unsupported where write_mesh knows no format for the path's ending: for asking before the work is done.
void check_mesh_path(const std::filesystem::path& path);

/// Writes by the ending of the path's name:
///   .vtu  VTK's XML UnstructuredGrid, raw appended data: tetrahedra with cell arrays `interval` (0, 1, ... in the order of the
///   request),
///         `lower` and `upper`, the extracted values as a point array `array_name`, and `more` point arrays;
///   .ply  the boundary facets, binary, with `interval` and `label` (0 lower, 1 upper, 2 domain) for each face;
///   .stl  the boundary facets, binary, the label in the attribute bytes.
/// The file is complete or not there: it is written beside the path and renamed. Precondition for .ply and .stl: extracted with
/// facets. Throws unsupported (another ending), unavailable (cannot write).
void write_mesh(const std::filesystem::path& path, const IntervalMesh& mesh, const std::string& array_name,
                std::span<const MeshArray> more);

}  // namespace isostrata
