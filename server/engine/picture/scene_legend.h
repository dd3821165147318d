// What is written beside a picture: the legend of its layers.
#pragma once

#include "engine/picture/extracted_scene.h"
#include "rendering/annotations/annotations.h"
#include "rendering/picture/renderer.h"
#include "scene/scene.h"

namespace isostrata {

/// What the scene wants beside that picture. `input` is of draw_input for the same scene.
AnnotationInput annotation_input(const ExtractedScene& extracted, const Scene& scene, const DrawInput& input);

}  // namespace isostrata
