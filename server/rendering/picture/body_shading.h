// How interiors are shaded: diffusely, by the gradient of the field, with a light at the eye.
//
// Source: M. Levoy, "Display of Surfaces from Volume Data", 1988, with the gradient's direction as the normal, of either sign, and
// without highlights. At a point of the mesh the share
//   f = 1 - s (1 - |n . v|)
// of the light is left: n along the gradient, v towards the eye, s the strength. It runs linearly in a tetrahedron, so neighbours
// meet without an edge, and a segment of a ray that adds light L and has opacity a adds
//   L (f_in + (f_out - f_in) m(a))
// instead. m is where the light of a segment of one extinction comes from on average (middle_of_light): of one colour and one
// extinction that is the exact integral. Opacities and depths stay as they are, and so do surfaces, which have a light of their own.
#pragma once

#include <cmath>

#include "base/buffer.h"
#include "base/vec.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// Whether any interior may be shaded.
inline bool shades_bodies(const DrawInput& input) { return input.body_shading > 0 && input.body_normals != nullptr; }

/// f. towards_eye: of any length. 1, unshaded, where the normal is zero: there is no gradient.
inline double body_shade(Vec3f normal, Vec3d towards_eye, double strength) {
  const Vec3d n{double{normal.x}, double{normal.y}, double{normal.z}};
  const double size = std::sqrt(dot(n, n) * dot(towards_eye, towards_eye));
  const double c = std::abs(dot(n, towards_eye)) / size;
  return c < 1 ? 1 - strength * (1 - c) : 1;  // false for NaN
}

/// Where in a segment of this opacity the light that leaves it comes from on average, as a share of its length: 0 is its front.
inline double middle_of_light(double alpha) {
  if (!(alpha > 1e-3)) return 0.5 - alpha / 12;
  if (alpha >= 1) return 0;
  return -1 / std::log1p(-alpha) - (1 - alpha) / alpha;
}

/// [np] body_shade at the mesh's points. Precondition: shades_bodies(input). Parallel.
Buffer<float> body_shades(const DrawInput& input);

}  // namespace isostrata
