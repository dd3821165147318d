// The device's renderer and the CPU's side by side: each picture is drawn by the one that draws it sooner.
#pragma once

#include <memory>

#include "rendering/picture/renderer.h"

namespace isostrata {

/// Constant colours are the CPU's at first: it draws them by the facets, so that an end that is moved costs it no mesh of tetrahedra, and a device that
/// mesh on its way there each time. Colours that run are the device's at first. A mesh that then takes long is drawn by the quicker (frame_judge.h).
/// Intervals that are cut in the rays are the CPU's, layers that the device extracts the device's. `device`: of make_device_or_native. Thread: the device's.
std::unique_ptr<Renderer> make_quicker_renderer(std::unique_ptr<Renderer> device);

}  // namespace isostrata
