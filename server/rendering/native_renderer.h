// The renderer on the CPU: no device, no driver.
#pragma once

#include <memory>

#include "rendering/renderer.h"

namespace isostrata {

std::unique_ptr<Renderer> make_native_renderer();

}  // namespace isostrata
