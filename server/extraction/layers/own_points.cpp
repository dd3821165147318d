#include "extraction/layers/own_points.h"

#include <limits>

#include "extraction/layers/join_meshes.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {

OwnPoints with_own_points(const IntervalMesh& mesh, std::uint64_t max_bytes) {
  OwnPoints out;
  out.mesh = mesh;
  out.mesh.origins = {};
  out.mesh.values = {};
  const bool flat = mesh.tetrahedra.empty();
  const std::size_t simplices = flat ? mesh.facets.size() : mesh.tetrahedra.size();
  std::vector<std::uint32_t> cell_of(mesh.positions.size(), std::numeric_limits<std::uint32_t>::max()), own(mesh.positions.size());
  std::size_t facet = 0;
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    const std::size_t first = mesh.cell_runs[r].first_tetrahedron, end = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : simplices;
    const auto renumber = [&](auto& points) {
      for (std::uint32_t& p : points) {
        if (cell_of[p] != r) {
          cell_of[p] = static_cast<std::uint32_t>(r);
          own[p] = static_cast<std::uint32_t>(out.point.size());
          out.point.push_back(p);
          out.simplex.push_back(static_cast<std::uint32_t>(first));
        }
        p = own[p];
      }
    };
    if (!flat)
      for (std::size_t t = first; t < end; ++t) renumber(out.mesh.tetrahedra[t]);
    for (; facet < mesh.facets.size() && (flat ? facet : mesh.facets[facet].tetrahedron) < end; ++facet) renumber(out.mesh.facets[facet].points);
    if (out.point.size() + 64 > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::too_large, "cells with points of their own: expected fewer than 2^32 points: narrow the intervals");
  }
  check_budget("cells with points of their own", mesh_bytes(mesh) + out.point.size() * (sizeof(Vec3d) + 2 * sizeof(std::uint32_t)), max_bytes);
  out.mesh.positions.resize(out.point.size());
  for (std::size_t i = 0; i < out.point.size(); ++i) out.mesh.positions[i] = mesh.positions[out.point[i]];
  return out;
}

}  // namespace isostrata
