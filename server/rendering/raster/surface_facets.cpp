#include "rendering/raster/surface_facets.h"

#include <algorithm>

#include "base/parallel.h"

namespace isostrata {

SurfaceFacets sort_facets(const IntervalMesh& mesh) {
  SurfaceFacets out;
  if (mesh.facets.empty()) return out;
  const auto usable = [&](const BoundaryFacet& facet) {
    return facet.tetrahedron < mesh.tetrahedra.size() && facet.interval < mesh.summaries.size() &&
           std::all_of(facet.points.begin(), facet.points.end(), [&](std::uint32_t p) { return p < mesh.positions.size(); });
  };
  // A counting sort by tetrahedron.
  std::vector<std::uint32_t> start(mesh.tetrahedra.size() + 1, 0);
  for (const BoundaryFacet& facet : mesh.facets)
    if (usable(facet)) ++start[facet.tetrahedron + 1];
  out.first_of.resize(mesh.tetrahedra.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    out.first_of[t] = start[t + 1] > 0 ? start[t] : kNoFacet;
    start[t + 1] += start[t];
  }
  out.facets.resize(start.back());
  for (std::size_t f = 0; f < mesh.facets.size(); ++f)
    if (usable(mesh.facets[f])) out.facets[start[mesh.facets[f].tetrahedron]++] = static_cast<std::uint32_t>(f);
  return out;
}

std::vector<shaders::FacetCorner> facet_corners(const DrawInput& input, const SurfaceFacets& facets, Vec3d centre, double scale) {
  const IntervalMesh& mesh = *input.mesh;
  const auto np = mesh.positions.size();
  const auto* scalars = input.color_values && input.color_values->size() == np ? input.color_values.get() : nullptr;
  const auto* normals = input.normals && input.normals->size() == np ? input.normals.get() : nullptr;
  const auto* textures = input.texture_values && input.texture_values->size() == np ? input.texture_values.get() : nullptr;
  std::vector<shaders::FacetCorner> corners(3 * facets.facets.size());
  parallel_for(static_cast<std::int64_t>(facets.facets.size()), 4096, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i)
      for (std::size_t v = 0; v < 3; ++v) {
        const std::uint32_t point = mesh.facets[facets.facets[i]].points[v];
        const Vec3d p = (mesh.positions[point] - centre) / scale;
        const Vec3f normal = normals ? (*normals)[point] : Vec3f{};
        corners[3 * i + v] = {
            {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), scalars ? (*scalars)[point] : 0.0f},
            {normal.x, normal.y, normal.z, textures ? (*textures)[point] : 0.0f}};
      }
  });
  return corners;
}

std::vector<std::uint32_t> drawn_parts(const std::vector<IntervalStyle>& styles) {
  std::vector<std::uint32_t> parts;
  for (const IntervalStyle& style : styles) {
    std::uint32_t bits = 0;
    if (style.visible) {
      if (style.has_interior()) bits |= DRAW_VOLUME;
      if (style.surface.drawn()) {
        const bool labels[3] = {style.surface.lower, style.surface.upper, style.surface.domain};
        for (std::uint32_t label = 0; label < 3; ++label)
          if (labels[label]) bits |= DRAW_LABEL << label;
      }
    }
    parts.push_back(bits);
  }
  return parts;
}

bool draws_surfaces(const DrawInput& input) {
  return std::any_of(input.styles.begin(), input.styles.end(),
                     [](const IntervalStyle& style) { return style.visible && style.surface.drawn(); });
}

}  // namespace isostrata
