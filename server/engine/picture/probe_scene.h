// What lies at a place of the picture: position, layer, values. It is found in the data, never in the picture's colours.
#pragma once

#include "base/task.h"
#include "engine/messages/probe.h"
#include "extraction/layers/extract_layers.h"
#include "rendering/picture/view_ray.h"
#include "scene/scene.h"

namespace isostrata {

struct ProbePlace {
  double x = 0.5, y = 0.5;        // as ProbeRequest
  int width = 800, height = 600;  // of the picture
};

/// Cuts the scene's layers out of the cells that the ray meets, with the tables, the terms and the times that its pictures are made with, and takes the
/// first tetrahedron that is seen: so the answer is where the picture's layers are, on any number of points. In priority mode that is the layer which is
/// painted last of those that the ray meets, and of a smear the last step or time that the ray meets. The scene's array may be empty: the first.
/// Throws what extract_layers throws; invalid_argument (a place outside the picture); unsupported (a part of a dataset that others hold the rest of). Any
/// thread.
ProbeFacts probe_scene(const StepSource& steps, const Scene& scene, const ProbePlace& place, const Task& task);

}  // namespace isostrata
