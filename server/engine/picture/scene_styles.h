// How the extracted layers of a scene look: the style of each.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/picture/extracted_scene.h"
#include "rendering/picture/renderer.h"
#include "scene/scene.h"

namespace isostrata {

/// One for each of extracted.summaries(). Those of a flat grid are surfaces. Of a smear each step or time has one colour, over those before it. Of a cycle
/// the intervals but one are hidden.
std::vector<IntervalStyle> scene_styles(const ExtractedScene& extracted, const Scene& scene);

/// How many pictures a cycle has: intervals, and terms that bring something in, that are not hidden.
std::size_t cycle_length(const Scene& scene);

/// Whether the i-th interval and the one before it are parts of one (drawn_scene).
bool continues_interval(const Scene& scene, std::size_t i);

}  // namespace isostrata
