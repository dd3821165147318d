// A device's renderer, beside which the native one draws what the device does not.
#pragma once

#include <memory>

#include "rendering/picture/renderer.h"

namespace isostrata {

/// Draws on the device, and with the native renderer what the device has no room for (it throws too_large): such a mesh, and pictures of it that need
/// no less, are then not tried there again. The facts' device says in place of what was drawn and why. The areas of flat grids are drawn natively, too:
/// the OpenGL renderers draw a surface with the tetrahedron that it bounds. Thread: the device's.
std::unique_ptr<Renderer> make_device_or_native(std::unique_ptr<Renderer> device);

}  // namespace isostrata
