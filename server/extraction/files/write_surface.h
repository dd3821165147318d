// The boundary of interval volumes as triangle files.
#pragma once

#include <span>

#include "base/task.h"
#include "extraction/files/output_file.h"
#include "extraction/files/write_mesh.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Whether a facet matches any of the choices; all do if there is none.
bool is_chosen(const BoundaryFacet& facet, std::span<const FacetChoice> choices);

/// What write_mesh writes for .ply and .stl.
void write_ply(OutputFile& out, const IntervalMesh& mesh, std::span<const MeshArray> more, std::span<const FacetChoice> choices,
               const Task& task);
void write_stl(OutputFile& out, const IntervalMesh& mesh, std::span<const FacetChoice> choices, const Task& task);

}  // namespace isostrata
