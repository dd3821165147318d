// A picture lit by its depth, if its scene says so.
#pragma once

#include "rendering/picture/renderer.h"
#include "scene/depth_light.h"

namespace isostrata {

/// What input asks for, of the whole picture. The renderer draws floats with their mean depth, which are lit and only then rounded; the light's
/// time is in draw_ms and among the stages. Without light just renderer.draw(input). Throws what that throws, and what LightRows throws.
DrawResult draw_lit(Renderer& renderer, const DrawInput& input, const DepthLight& light);

}  // namespace isostrata
