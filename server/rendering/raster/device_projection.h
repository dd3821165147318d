// Projected tetrahedra made on the device: a list of tetrahedra goes up, or is there already, and nothing comes back. Each batch
// is projected by a compute program into vertices and draw commands (shaders/project_tetrahedra.comp), then drawn indirectly.
#pragma once

#include <cstdint>
#include <map>
#include <span>

#include "rendering/gl/gl_objects.h"

namespace isostrata {

/// The context is current in every call.
class DeviceProjection {
 public:
  /// largest_buffer: bytes that a storage buffer may have.
  DeviceProjection(const GlFunctions& gl, std::uint64_t largest_buffer);

  /// Whether the device has as many storage buffers as the program binds. OpenGL 4.5 promises fewer; all GPUs met have them.
  static bool works(const GlFunctions& gl);

  struct Variant {
    bool linear = false, orthographic = false, surfaces = false, shaded = false;
    std::uint64_t vertex_words() const;
    auto operator<=>(const Variant&) const = default;
  };

  /// Puts there what is the same for all tiles of a frame. order: tetrahedra, back to front; parts: drawn_parts(). False where
  /// the device has no room: then draw must not be called.
  bool prepare(const Variant& variant, std::span<const std::uint32_t> order, std::span<const std::uint32_t> parts);
  /// Into the framebuffer, with the drawing program and the vertex array's formats given. The mesh, the facets and the frame's
  /// block are bound.
  void draw(GLuint drawing_program, GLuint vertex_array);

 private:
  struct Batch {
    GlObject vertices, commands;
    std::uint64_t bytes = 0;
  };
  bool reserve(GlObject& buffer, std::uint64_t& held, std::uint64_t bytes, GLbitfield flags);

  const GlFunctions& gl_;
  const std::uint64_t largest_buffer_;
  std::map<Variant, GlObject> programs_;
  GlObject order_, parts_;
  std::uint64_t order_bytes_ = 0, parts_bytes_ = 0;
  Batch batches_[2];  // one is drawn while the other is made
  Variant variant_;
  std::size_t count_ = 0;
};

}  // namespace isostrata
