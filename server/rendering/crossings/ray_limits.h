// What clip planes leave of each pixel's ray.
#pragma once

#include <span>

#include "rendering/crossings/facet_spans.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// Depths relative to the reference, rows of `stride` floats from the rect's upper left pixel: the ray is cut to
/// [nearest, farthest], which is empty if nearest >= farthest. Exact: each plane bounds the depth by a quotient of two
/// functions that are linear on the screen. The near depth is one of the bounds.
void limit_rays(const ScreenTransform& transform, std::span<const ClipPlane> planes, const PixelRect& rect, std::size_t stride,
                float* nearest, float* farthest);

}  // namespace isostrata
