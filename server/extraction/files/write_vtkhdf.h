// Interval meshes as VTKHDF: files that are written as fast as the disk takes them, and read without being unpacked.
#pragma once

#include <span>
#include <string>

#include "base/task.h"
#include "extraction/files/output_file.h"
#include "extraction/files/write_vtu.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// What write_vtu writes, as an UnstructuredGrid of VTKHDF 1.0 (vtkHDFReader of VTK 9.1 and newer), not compressed. Of HDF5 it takes what is
/// needed: a superblock, two levels of groups, attributes, and contiguous arrays, by "HDF5 File Format Specification Version 3.0". Throws as write_mesh.
void write_vtkhdf(OutputFile& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more, const Task& task);

}  // namespace isostrata
