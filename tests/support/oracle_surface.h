// The light of a boundary surface where a ray crosses it.
#pragma once

#include <algorithm>
#include <cmath>

#include "rendering/picture/surface_shading.h"
#include "support/oracle_light.h"
#include "support/oracle_ray.h"

namespace isostrata::testing {

inline bool oracle_draws(const SurfaceStyle& surface, FacetLabel label) {
  if (!surface.drawn()) return false;
  return label == FacetLabel::lower ? surface.lower : label == FacetLabel::upper ? surface.upper : surface.domain;
}

/// optics, material: of the facet's interval. Values and normals run linearly over the facet; the shading is the renderers' own
/// reference, in single precision.
inline OracleLight oracle_surface(const DrawInput& input, const OracleOptics& optics, const SurfaceMaterial& material,
                                  const OracleRay& ray, const OracleCrossing& crossing) {
  const IntervalMesh& mesh = *input.mesh;
  const BoundaryFacet& facet = mesh.facets[crossing.facet];
  const auto value_of = [&](const std::shared_ptr<const std::vector<float>>& values) {
    double value = 0;
    if (values)
      for (std::size_t v = 0; v < 3; ++v) value += crossing.weights[v] * (*values)[facet.points[v]];
    return value;
  };
  const Vec3d a = mesh.positions[facet.points[0]];
  const Vec3d own_normal = normalized(cross(mesh.positions[facet.points[1]] - a, mesh.positions[facet.points[2]] - a));
  Vec3d normal = own_normal;
  if (input.normals) {
    normal = {};
    for (std::size_t v = 0; v < 3; ++v) {
      const Vec3f n = (*input.normals)[facet.points[v]];
      normal = normal + Vec3d{n.x, n.y, n.z} * crossing.weights[v];
    }
  }
  const auto color = optics.color(optics.place(value_of(input.color_values)));
  const auto single = [](Vec3d v) { return Vec3f{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; };
  const SurfaceColor shaded =
      shade_surface(material, {static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])},
                    single(normal), single(own_normal), single(ray.direction * -1.0),
                    static_cast<float>(value_of(input.texture_values)));
  return {{shaded.color[0], shaded.color[1], shaded.color[2]}, shaded.alpha};
}

}  // namespace isostrata::testing
