// Cuts a tetrahedron by the planes of a pyramid of view.
#pragma once

#include <array>
#include <vector>

#include "base/vec.h"

namespace isostrata {

struct ClipVertex {
  Vec3d position;  // view space, depth positive: x right, y up, z away from the eye
  double scalar = 0;
  double shade = 1;  // body_shading.h
};
using ClipTetrahedron = std::array<ClipVertex, 4>;

/// Keeps dot(normal, position) >= offset of every tetrahedron in `pieces`; a tetrahedron that is cut becomes one to three.
void clip_tetrahedra(std::vector<ClipTetrahedron>& pieces, Vec3d normal, double offset);

}  // namespace isostrata
