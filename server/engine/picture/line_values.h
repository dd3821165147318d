// The values of an array along a line through the data.
#pragma once

#include <string>
#include <vector>

#include "base/task.h"
#include "engine/messages/probe.h"
#include "extraction/layers/extract_layers.h"
#include "scene/scene.h"

namespace isostrata {

/// At the scene's time or step; of a smear at its first. The cells that the line may meet are cut into the tetrahedra that pictures are made of, in which the
/// field is linear: so samples lie where the line goes from one to the next, and between them the value runs straight. Of a line on faces or edges of cells one
/// of the cells there is taken. Of flat grids only lines that lie in them have values. array: empty: the scene's. At most kMostCurveSamples, thin_curve.
/// Throws invalid_argument (ends that are not finite or the same); not_found (the array); and what RayLayers throws. Any thread.
CurveFacts line_values(const StepSource& steps, const Scene& scene, const std::string& array, Vec3d from, Vec3d to, const Task& task);

inline constexpr std::size_t kMostCurveSamples = 4096;
/// Where there are more samples: those that are drawn and said of each of so many equal stretches, the first, the last, the least and the greatest, and its gaps.
void thin_curve(CurveFacts& curve);

}  // namespace isostrata
