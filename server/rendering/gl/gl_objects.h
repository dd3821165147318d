// OpenGL objects that delete themselves. They may only live while their context does, and be destroyed if it is current.
#pragma once

#include <string>
#include <utility>

#include "rendering/gl/gl_functions.h"

namespace isostrata {

/// One object name and how to delete it.
class GlObject {
 public:
  GlObject() = default;
  GlObject(const GlFunctions* gl, GLuint name, void (*remove)(const GlFunctions&, GLuint))
      : gl_(gl), name_(name), remove_(remove) {}
  GlObject(GlObject&& other) noexcept { swap(other); }
  GlObject& operator=(GlObject&& other) noexcept {
    swap(other);
    return *this;
  }
  ~GlObject() {
    if (name_) remove_(*gl_, name_);
  }
  GLuint name() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  void swap(GlObject& other) {
    std::swap(gl_, other.gl_);
    std::swap(name_, other.name_);
    std::swap(remove_, other.remove_);
  }
  const GlFunctions* gl_ = nullptr;
  GLuint name_ = 0;
  void (*remove_)(const GlFunctions&, GLuint) = nullptr;
};

GlObject make_buffer(const GlFunctions& gl);
GlObject make_texture(const GlFunctions& gl, GLenum target);
GlObject make_framebuffer(const GlFunctions& gl);
GlObject make_vertex_array(const GlFunctions& gl);
GlObject make_query(const GlFunctions& gl, GLenum target);

/// Compiles and links two shaders of this room with `defines` ("#define LINEAR_COLOR\n"). Throws internal with the driver's log.
GlObject make_program(const GlFunctions& gl, const char* vertex_source, const char* fragment_source, const std::string& defines);

/// Compiles and links a compute shader of this room; `shared_source` comes before `source`. Throws internal with the driver's
/// log.
GlObject make_compute_program(const GlFunctions& gl, const char* shared_source, const char* source, const std::string& defines);

/// A texture of one level. Throws too_large if the driver has no memory for it.
GlObject make_texture_2d(const GlFunctions& gl, GLenum format, int width, int height);

}  // namespace isostrata
