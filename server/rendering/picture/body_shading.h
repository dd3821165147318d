// How interiors are shaded: diffusely, by the gradient of the field, with a light at the eye.
//
// Source: M. Levoy, "Display of Surfaces from Volume Data", 1988, with the gradient's direction as the normal, of either sign, and
// without highlights. At a point of the mesh the share
//   f = 1 - s (1 - |n . v|)
// of the light is left: n along the gradient, v towards the eye, s the strength. It runs linearly in a tetrahedron, so neighbours
// meet without an edge, and a segment of a ray that adds light L and has opacity a adds
//   L (f_in + (f_out - f_in) m(a))
// instead. m is where the light of a segment of one extinction comes from on average, 0 its front: m(a) = -1 / log(1 - a) - (1 - a) / a. Of one colour and one
// extinction that is the exact integral. Opacities and depths stay as they are, and so do surfaces, which have a light of their own.
#pragma once

#include "base/buffer.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// Whether any interior may be shaded.
inline bool shades_bodies(const DrawInput& input) { return input.body_shading > 0 && input.body_normals != nullptr; }

/// [np] f at the mesh's points; 1, unshaded, where the normal is zero: there is no gradient. Precondition: shades_bodies(input). Parallel.
Buffer<float> body_shades(const DrawInput& input);

}  // namespace isostrata
