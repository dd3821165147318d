// Projected tetrahedra drawn by OpenGL, back to front, into a float target.
#pragma once

#include <memory>
#include <string>

#include "rendering/gl_context.h"
#include "rendering/renderer.h"

namespace isostrata {

/// Takes a context that is current; opens `device` anew where it was lost.
std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, std::string device);

}  // namespace isostrata
