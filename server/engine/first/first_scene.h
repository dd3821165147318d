// A first view as a scene has it.
#pragma once

#include <vector>

#include "engine/first/first_view.h"
#include "scene/scene.h"

namespace isostrata {

/// Its layers, numbered from 1, with ids that are these numbers; the later ones are painted over the earlier ones.
std::vector<SceneInterval> first_intervals(const FirstView& view);

/// What it shows, for a picture `aspect` times as wide as high.
Scene first_scene(const FirstView& view, double aspect);

}  // namespace isostrata
