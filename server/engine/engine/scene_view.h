// The parts of a scene that a picture of older layers can still follow: camera, background, light and the like.
#pragma once

#include "scene/scene.h"

namespace isostrata {

/// `of` is seen as `from`. A smear's mesh is another one, so its mode stays with what was extracted.
void take_view(Scene& of, const Scene& from);
/// Whether pictures of the same layers would be the same.
bool same_view(const Scene& a, const Scene& b);

}  // namespace isostrata
