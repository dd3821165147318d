// Where a ray lies in one tetrahedron, or in one triangle of a flat grid.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "extraction/mesh/interval_mesh.h"
#include "rendering/picture/view_ray.h"

namespace isostrata {

/// From enter to leave along the ray; a triangle that the ray crosses is met at one place.
struct RayStretch {
  double enter = 0, leave = 0;
  std::size_t corners = 4;
  std::array<std::uint32_t, 4> points{};       // of the mesh
  std::array<double, 4> at{}, along{};         // corner v counts at[v] + t * along[v]

  std::array<double, 4> weights(double t) const;  // none negative; they add up to 1
};

/// A hair more than it holds, so that a ray on the face between two is lost by neither. Nothing of one that is missed or only touched, or has no volume.
std::optional<RayStretch> tetrahedron_stretch(const IntervalMesh& mesh, std::size_t tetrahedron, const ViewRay& ray);
/// Of mesh.facets.
std::optional<RayStretch> triangle_stretch(const IntervalMesh& mesh, std::size_t facet, const ViewRay& ray);

/// Calls found(item, interval, stretch) for each tetrahedron of the mesh that the ray meets, of a flat grid for each facet.
template <class Found>
void for_each_stretch(const IntervalMesh& mesh, const ViewRay& ray, const Found& found) {
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    if (const auto stretch = tetrahedron_stretch(mesh, t, ray)) found(t, mesh.tetrahedron_interval[t], *stretch);
  if (!mesh.tetrahedra.empty()) return;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f)
    if (const auto stretch = triangle_stretch(mesh, f, ray)) found(f, mesh.facets[f].interval, *stretch);
}

}  // namespace isostrata
