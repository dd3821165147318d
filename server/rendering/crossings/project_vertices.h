// All points of a mesh on the screen.
#pragma once

#include <span>

#include "base/buffer.h"
#include "rendering/crossings/screen_transform.h"

namespace isostrata {

/// ScreenTransform::project of each. Parallel, vectors of what the processor has; the same result whatever they are.
void project_vertices(std::span<const Vec3d> points, const ScreenTransform& transform, Buffer<ScreenVertex>& out);

}  // namespace isostrata
