// The boundary facets of a mesh by the tetrahedron that they bound, for drawing them in order with the volume.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "rendering/gl/layout.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

inline constexpr std::uint32_t kNoFacet = NO_FACET;

struct SurfaceFacets {
  std::vector<std::uint32_t> first_of;  // [nt] a tetrahedron's first facet or kNoFacet; empty if the mesh has no facets
  std::vector<std::uint32_t> facets;    // [facets of tetrahedra] indices into mesh.facets, by tetrahedron
};

/// Facets whose tetrahedron or points do not exist are left out. O(n).
SurfaceFacets sort_facets(const IntervalMesh& mesh);

/// What the shader looks up, three corners a facet in the order of SurfaceFacets::facets: points less `centre` over `scale`,
/// color-by values, normals and texture values if there are any. Parallel.
std::vector<shaders::FacetCorner> facet_corners(const DrawInput& input, const SurfaceFacets& facets, Vec3d centre, double scale);

/// DRAW_... bits of each interval: whether its volume and which of its facets are drawn.
std::vector<std::uint32_t> drawn_parts(const std::vector<IntervalStyle>& styles);

/// Whether any interval's surface is drawn.
bool draws_surfaces(const DrawInput& input);

}  // namespace isostrata
