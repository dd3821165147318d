// A smear: the layers of several steps or times in one mesh.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "engine/picture/extracted_scene.h"
#include "engine/picture/layer_request.h"
#include "scene/scene.h"

namespace isostrata {

/// Joins what `extract` gives for the scene at each of the moments (smear_moments, at least one). Before the second one its memory is foreseen from
/// the first one's: throws too_large, with the numbers, if that is more than max_bytes; and what `extract` throws.
std::shared_ptr<const ExtractedScene> extract_smear(const Scene& scene, const std::vector<SmearMoment>& moments, std::uint64_t max_bytes,
                                                    const std::function<std::shared_ptr<const ExtractedScene>(const Scene&)>& extract);

}  // namespace isostrata
