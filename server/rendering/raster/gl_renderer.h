// Projected tetrahedra drawn by OpenGL, back to front, into a float target.
#pragma once

#include <memory>
#include <string>

#include "rendering/gl/gl_context.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// Where tetrahedra are projected and classified.
enum class ProjectOn {
  automatic,  // the device if it is a GPU and has room for the mesh, else the CPU
  cpu,        // all cores; vertices are streamed to the device
  device      // compute programs, if there is room for the mesh, else the CPU
};

/// Takes a context that is current; opens `device` anew if it was lost.
std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, std::string device,
                                           ProjectOn project_on = ProjectOn::automatic);

}  // namespace isostrata
