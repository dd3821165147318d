// Where a ray enters the first layer of a mesh that is seen.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "extraction/mesh/interval_mesh.h"
#include "rendering/picture/view_ray.h"
#include "scene/style.h"

namespace isostrata {

struct RayHit {
  double at = 0, leave = 0;  // along the ray: if it is entered, and where the tetrahedron is left; both the same of a facet
  std::size_t style = 0;     // of the interval
  std::size_t item = 0;      // the tetrahedron, or of a surface the facet
  bool surface = false;
  std::array<std::uint32_t, 4> points{};  // of the mesh, and how much each counts at the hit; of a facet the first three
  std::array<double, 4> weights{};
  const BoundaryFacet* facet = nullptr;  // that the ray comes through, in the mesh; null: none
};

/// A layer with an interior that is seen begins where its solid does, any other at the surfaces that are drawn of it. The nearest is taken; by_priority:
/// of those with the highest priority, since they are painted over the others. Hidden layers, and those of which nothing is drawn, are looked through.
/// styles: one for each of the mesh's summaries. Nothing if the ray meets none. Any thread.
std::optional<RayHit> first_hit(const IntervalMesh& mesh, std::span<const IntervalStyle> styles, bool by_priority, const ViewRay& ray);

/// Whether the ray meets a tetrahedron of the mesh, or of a flat grid a facet, at `at`.
bool meets_at(const IntervalMesh& mesh, const ViewRay& ray, double at);

}  // namespace isostrata
