// Vertices on their way to the device: one buffer, mapped for good, in a few regions that are filled and drawn in turn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "rendering/gl/gl_objects.h"

namespace isostrata {

class VertexStream {
 public:
  /// bytes: of one region. Throws too_large if the device has no memory.
  VertexStream(const GlFunctions& gl, std::size_t bytes);
  ~VertexStream();
  VertexStream(const VertexStream&) = delete;
  VertexStream& operator=(const VertexStream&) = delete;

  GLuint buffer() const { return buffer_.name(); }

  /// Copies triangles of vertices of `stride` bytes, calling `draw` for every region that is full. `draw` must be followed by
  /// flush() or more write() calls with the same stride.
  using Draw = std::function<void(std::size_t offset_bytes, std::int32_t vertices)>;
  void write(std::span<const std::byte> triangles, std::size_t stride, const Draw& draw);
  void flush(std::size_t stride, const Draw& draw);

 private:
  static constexpr std::size_t kRegions = 3;
  void wait_for_region();

  const GlFunctions& gl_;
  std::size_t bytes_;
  GlObject buffer_;
  std::byte* mapped_ = nullptr;
  std::size_t region_ = 0, used_ = 0;
  std::array<GLsync, kRegions> fence_{};  // signalled once the region has been drawn from
};

}  // namespace isostrata
