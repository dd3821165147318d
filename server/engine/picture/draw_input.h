// Extracted layers and a scene, as a renderer takes them.
#pragma once

#include "engine/picture/extracted_scene.h"
#include "rendering/picture/renderer.h"
#include "scene/scene.h"

namespace isostrata {

/// What the renderer needs for the scene at this size. `extracted` must belong to the scene's ends, terms and arrays.
DrawInput draw_input(const ExtractedScene& extracted, const Scene& scene, int width, int height);

}  // namespace isostrata
