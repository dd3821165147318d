#include "rendering/raster/vertex_stream.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "base/error.h"

namespace isostrata {

VertexStream::VertexStream(const GlFunctions& gl, std::size_t bytes) : gl_(gl), bytes_(bytes), buffer_(make_buffer(gl)) {
  constexpr GLbitfield kFlags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  const auto total = static_cast<GLsizeiptr>(bytes_ * kRegions);
  gl_.NamedBufferStorage(buffer_.name(), total, nullptr, kFlags);
  if (gl_.GetError() == GL_NO_ERROR) mapped_ = static_cast<std::byte*>(gl_.MapNamedBufferRange(buffer_.name(), 0, total, kFlags));
  if (!mapped_) throw Error(ErrorCode::too_large, "the device has no room for " + std::to_string(total) + " bytes of vertices");
}

VertexStream::~VertexStream() {
  for (const GLsync fence : fence_)
    if (fence) gl_.DeleteSync(fence);
}

void VertexStream::wait_for_region() {
  GLsync& fence = fence_[region_];
  if (!fence) return;
  const GLenum state = gl_.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 60'000'000'000);
  gl_.DeleteSync(fence);
  fence = nullptr;
  if (state == GL_WAIT_FAILED) throw Error(ErrorCode::unavailable, "waiting for the device failed: its context is lost");
  if (state != GL_ALREADY_SIGNALED && state != GL_CONDITION_SATISFIED)
    throw Error(ErrorCode::unavailable, "the device has not drawn a batch of triangles within 60 s");
}

void VertexStream::write(std::span<const std::byte> triangles, std::size_t stride, const Draw& draw) {
  const std::size_t capacity = bytes_ / (3 * stride) * (3 * stride);
  while (!triangles.empty()) {
    if (used_ == 0) wait_for_region();
    const std::size_t n = std::min(triangles.size(), capacity - used_);
    std::memcpy(mapped_ + region_ * bytes_ + used_, triangles.data(), n);
    used_ += n;
    triangles = triangles.subspan(n);
    if (used_ == capacity) flush(stride, draw);
  }
}

void VertexStream::flush(std::size_t stride, const Draw& draw) {
  if (used_ == 0) return;
  draw(region_ * bytes_, static_cast<std::int32_t>(used_ / stride));
  fence_[region_] = gl_.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  region_ = (region_ + 1) % kRegions;
  used_ = 0;
}

}  // namespace isostrata
