#include "extraction/layers/join_meshes.h"

#include <algorithm>
#include <string>

#include "base/error.h"

namespace isostrata {
namespace {

template <class T>
std::uint64_t bytes_of(const T& array) {
  return array.size() * sizeof(array[0]);
}

void check_limit(std::uint64_t count, std::uint64_t limit, const char* what) {
  if (count > limit)
    throw Error(ErrorCode::too_large,
                "joining meshes: " + std::to_string(count) + " " + what + "; at most " + std::to_string(limit) + " are possible");
}

}  // namespace

std::uint64_t mesh_bytes(const IntervalMesh& mesh) {
  return bytes_of(mesh.positions) + bytes_of(mesh.origins) + bytes_of(mesh.values) + bytes_of(mesh.tetrahedra) +
         bytes_of(mesh.tetrahedron_interval) + bytes_of(mesh.cell_runs) + bytes_of(mesh.facets);
}

IntervalMesh join_meshes(std::span<const IntervalMesh* const> meshes, std::uint64_t max_bytes) {
  std::uint64_t points = 0, tetrahedra = 0, runs = 0, facets = 0, summaries = 0;
  for (const IntervalMesh* mesh : meshes) {
    points += mesh->positions.size();
    tetrahedra += mesh->tetrahedra.size();
    runs += mesh->cell_runs.size();
    facets += mesh->facets.size();
    summaries += mesh->summaries.size();
  }
  check_limit(points, UINT32_MAX, "points");
  check_limit(tetrahedra, UINT32_MAX, "tetrahedra");
  check_limit(summaries, UINT16_MAX, "intervals");
  const std::uint64_t bytes = points * sizeof(Vec3d) +
                              tetrahedra * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t)) +
                              runs * sizeof(CellRun) + facets * sizeof(BoundaryFacet);
  if (bytes > max_bytes)
    throw Error(ErrorCode::too_large, "joining meshes needs " + std::to_string(bytes >> 20) + " MiB; " +
                                          std::to_string(max_bytes >> 20) + " MiB are allowed");

  IntervalMesh joined;
  joined.positions.resize(points);
  joined.tetrahedra.resize(tetrahedra);
  joined.tetrahedron_interval.resize(tetrahedra);
  joined.cell_runs.resize(runs);
  joined.facets.reserve(facets);
  joined.summaries.reserve(summaries);
  std::size_t point = 0, tetrahedron = 0, run = 0;
  for (const IntervalMesh* mesh : meshes) {
    const auto first_point = static_cast<std::uint32_t>(point), first_tetrahedron = static_cast<std::uint32_t>(tetrahedron);
    const auto first_interval = static_cast<std::uint16_t>(joined.summaries.size());
    point = static_cast<std::size_t>(
        std::copy(mesh->positions.begin(), mesh->positions.end(), joined.positions.begin() + static_cast<std::ptrdiff_t>(point)) -
        joined.positions.begin());
    for (std::size_t t = 0; t < mesh->tetrahedra.size(); ++t, ++tetrahedron) {
      for (std::size_t v = 0; v < 4; ++v) joined.tetrahedra[tetrahedron][v] = mesh->tetrahedra[t][v] + first_point;
      joined.tetrahedron_interval[tetrahedron] = static_cast<std::uint16_t>(mesh->tetrahedron_interval[t] + first_interval);
    }
    for (const CellRun& of : mesh->cell_runs) joined.cell_runs[run++] = {of.cell, of.first_tetrahedron + first_tetrahedron};
    for (BoundaryFacet facet : mesh->facets) {
      for (std::uint32_t& p : facet.points) p += first_point;
      facet.tetrahedron += first_tetrahedron;
      facet.interval = static_cast<std::uint16_t>(facet.interval + first_interval);
      joined.facets.push_back(facet);
    }
    joined.summaries.insert(joined.summaries.end(), mesh->summaries.begin(), mesh->summaries.end());
    joined.cells = std::max(joined.cells, mesh->cells);
    joined.active_cells += mesh->active_cells;
  }
  return joined;
}

}  // namespace isostrata
