// What compute work needs of an OpenGL context: programs, storage buffers within a budget, dispatches of bounded length, clear
// errors.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "base/task.h"
#include "rendering/gl/gl_context.h"
#include "rendering/gl/gl_objects.h"

namespace isostrata {

/// A storage buffer. Only grows, by being made anew.
struct ComputeBuffer {
  GlObject object;
  std::uint64_t bytes = 0;
  GLuint name() const { return object.name(); }
};

class ComputeDevice {
 public:
  /// Takes a context. otherwise: what messages tell people to do without the device. Throws unavailable if the device has fewer storage buffers
  /// than the programs bind, or no compute at all.
  explicit ComputeDevice(std::unique_ptr<GlContext> context, std::string otherwise = "extract on the CPU");

  const GlContext& context() const { return *context_; }
  const GlFunctions& gl() const { return gl_; }
  void make_current() { context_->make_current(); }

  /// The most that all buffers together may take: at most nine tenths of what the driver says is free (NVIDIA, AMD), where it
  /// says so; 0 is that, or 4 GiB.
  void set_budget(std::uint64_t bytes);
  std::uint64_t allocated() const { return allocated_; }
  std::uint64_t largest_buffer() const { return largest_buffer_; }

  /// Makes the buffer at least that large; its contents are lost where it grows. Throws too_large, with the numbers, above
  /// largest_buffer() or the budget or where the driver has no room.
  void reserve(ComputeBuffer& buffer, std::uint64_t bytes, const std::string& what);
  void free(ComputeBuffer& buffer);
  /// Copies to the buffer, piece by piece. Throws cancelled.
  void upload(const ComputeBuffer& buffer, std::uint64_t offset, std::span<const std::byte> bytes, const Task& task);
  void clear(const ComputeBuffer& buffer, std::uint64_t bytes);
  /// Waits for the device, looking for cancel, then copies from the buffer.
  void read(const ComputeBuffer& buffer, std::uint64_t offset, std::span<std::byte> bytes, const Task& task);

  /// Compiled when first asked for.
  GLuint program(const char* source, const std::string& defines);
  /// Whether a program may have a buffer there. Below STORAGE_BUFFERS always.
  bool binds(GLuint binding) const { return static_cast<GLint>(binding) < storage_buffers_; }
  void bind(GLuint binding, const ComputeBuffer& buffer) { gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.name()); }

  /// Work groups that one dispatch may have: all that the driver takes on a GPU; few on a software device, so that cancel is
  /// noticed between dispatches (a group of 64 takes up to about half a millisecond there).
  std::uint32_t groups_a_dispatch() const { return groups_a_dispatch_; }
  /// Throws cancelled before it begins. What follows sees what was written only after barrier().
  void dispatch(GLuint program, std::uint32_t groups, const Task& task);
  void dispatch_indirect(GLuint program, const ComputeBuffer& groups, std::uint32_t slice, const Task& task);
  void barrier();

  /// Waits until the device is done. Throws cancelled (the device is then still at work), unavailable if the context was lost.
  void finish(const Task& task);
  /// Throws too_large for GL_OUT_OF_MEMORY, unavailable for a lost context and anything else.
  void check();

 private:
  std::unique_ptr<GlContext> context_;
  const std::string otherwise_;
  const GlFunctions& gl_;
  std::uint32_t groups_a_dispatch_ = 16;
  GLint storage_buffers_ = 0;
  std::uint64_t budget_ = 0, allocated_ = 0, largest_buffer_ = 0;
  std::map<std::pair<const char*, std::string>, GlObject> programs_;
};

/// Milliseconds of the device's own clock between two points of its work, or of ours where the device is software.
class ComputeTimer {
 public:
  explicit ComputeTimer(ComputeDevice& device);
  /// Call after ComputeDevice::finish.
  double elapsed_ms();
  /// Marks the end, before finish.
  void stop();

 private:
  ComputeDevice& device_;
  std::array<GlObject, 2> queries_;
  std::int64_t started_ns_ = 0;
};

}  // namespace isostrata
