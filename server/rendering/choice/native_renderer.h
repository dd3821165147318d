// The renderer on the CPU: no device, no driver.
#pragma once

#include <memory>

#include "rendering/picture/renderer.h"

namespace isostrata {

std::unique_ptr<Renderer> make_native_renderer();

/// Whether it is one of those: others like it may draw at the same time, and any thread may use it, one after the other.
bool needs_no_device(const Renderer& renderer);

}  // namespace isostrata
