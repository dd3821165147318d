// A first view as a scene has it.
#pragma once

#include <vector>

#include "engine/first/first_view.h"
#include "scene/scene.h"

namespace isostrata {

/// Its layers, numbered from 1, with ids that are these numbers; the later ones are painted over the earlier ones.
std::vector<SceneInterval> first_intervals(const FirstView& view);

}  // namespace isostrata
