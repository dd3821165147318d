// The tile algorithm in compute shaders (gl_tiles.h), behind the renderers' door.
#pragma once

#include <memory>
#include <string>

#include "rendering/gl/gl_context.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// Takes a context that is current; opens `device` anew if it was lost. Throws unavailable if the device has too few
/// storage buffers or too little shared memory.
std::unique_ptr<Renderer> make_compute_renderer(std::unique_ptr<GlContext> context, std::string device);

}  // namespace isostrata
