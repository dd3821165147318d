// The light of a boundary surface where a ray crosses it.
#pragma once

#include <algorithm>
#include <cmath>

#include "support/oracle_light.h"
#include "support/oracle_ray.h"

namespace isostrata::testing {

inline bool oracle_draws(const SurfaceStyle& surface, FacetLabel label) {
  if (!surface.drawn()) return false;
  return label == FacetLabel::lower ? surface.lower : label == FacetLabel::upper ? surface.upper : surface.domain;
}

/// optics: of the facet's interval.
inline OracleLight oracle_surface(const DrawInput& input, const OracleOptics& optics, const OracleRay& ray,
                                  const OracleCrossing& crossing) {
  const BoundaryFacet& facet = input.mesh->facets[crossing.facet];
  const SurfaceStyle& surface = input.styles[facet.interval].surface;
  double value = 0;
  if (input.color_values)
    for (std::size_t v = 0; v < 3; ++v) value += crossing.weights[v] * (*input.color_values)[facet.points[v]];
  const std::array<double, 3> own{surface.color[0], surface.color[1], surface.color[2]};
  OracleLight light{surface.own_color ? own : optics.color(optics.place(value)), surface.opacity};
  for (double& c : light.color) c *= light.alpha;
  (void)ray;
  return light;
}

}  // namespace isostrata::testing
