// Meshes in VTK's XML format for unstructured grids.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/task.h"
#include "extraction/files/output_file.h"
#include "extraction/files/vtk_xml.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// What a mesh is written as: the arrays of PointData, of CellData, Points, and of Cells: connectivity, offsets, types.
std::vector<VtkSection> mesh_sections(const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more);

/// What write_mesh writes for .vtu.
void write_vtu(OutputFile& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more,
               int compression, const Task& task);

/// The areas of a flat grid, or of a section, as VTK's XML PolyData (.vtp), with the arrays of write_vtu. Precondition: there are no tetrahedra.
void write_vtp(OutputFile& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more, int compression, const Task& task);

/// The list of .vtu files (.pvtu) that are one mesh: their names, and the arrays that write_vtu gave each of them. array_name: empty if they have no
/// values. Throws unavailable.
void write_pvtu(OutputFile& out, std::span<const std::string> pieces, const std::string& array_name, std::span<const std::string> more);

}  // namespace isostrata
