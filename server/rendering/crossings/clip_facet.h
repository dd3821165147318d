// Facets that reach too near to the eye or too far beyond the picture.
#pragma once

#include <vector>

#include "rendering/crossings/screen_transform.h"

namespace isostrata {

using ScreenTriangle = std::array<ScreenVertex, 3>;

/// Appends what of the triangle lies beyond the near depth and within the guard, in triangles of the same orientation. What an
/// edge is cut to is a function of its two ends alone, so that facets which share it stay together; vertices that stay are where
/// `on_screen` says, as in the facets that are not cut. No cap is put on the cut at the near depth: rays whose crossings do not
/// come out even begin inside.
void clip_facet(const ScreenTransform& transform, const std::array<ViewPoint, 3>& triangle, const ScreenTriangle& on_screen,
                std::vector<ScreenTriangle>& out);

}  // namespace isostrata
