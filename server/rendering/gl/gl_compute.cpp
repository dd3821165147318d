#include "rendering/gl/gl_compute.h"

#include <algorithm>
#include <chrono>
#include <string_view>

#include "base/error.h"
#include "rendering/gl/layout.h"
#include "rendering/shader_sources.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kPiece = 16ull << 20;         // bytes copied between two looks for cancel
constexpr std::uint64_t kUnknownBudget = 4ull << 30;  // where the driver does not say what is free
constexpr GLenum kNvidiaFree = 0x9049;                // GL_GPU_MEMORY_INFO_CURRENT_AVAILABLE_VIDMEM_NVX, in KiB
constexpr GLenum kAmdFree = 0x87FB;                   // GL_VBO_FREE_MEMORY_ATI: four numbers, the first in KiB
constexpr GLenum kContextLost = 0x0507;

bool has_extension(const GlFunctions& gl, std::string_view name) {
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i)
    if (std::string_view(reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)))) == name)
      return true;
  return false;
}

/// 0 if the driver does not say.
std::uint64_t free_bytes(const GlFunctions& gl) {
  GLint kib[4] = {0, 0, 0, 0};
  if (has_extension(gl, "GL_NVX_gpu_memory_info"))
    gl.GetIntegerv(kNvidiaFree, kib);
  else if (has_extension(gl, "GL_ATI_meminfo"))
    gl.GetIntegerv(kAmdFree, kib);
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(kib[0])) << 10;
}

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

ComputeDevice::ComputeDevice(std::unique_ptr<GlContext> context, std::string otherwise)
    : context_(std::move(context)), otherwise_(std::move(otherwise)), gl_(context_->gl()) {
  make_current();
  GLint64 allowed = 0;
  gl_.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &allowed);
  // Some drivers say 2^63 here and address less.
  largest_buffer_ = std::min<std::uint64_t>(static_cast<std::uint64_t>(allowed), 2ull << 30) / 16 * 16;
  GLint blocks = 0, bindings = 0, shared = 0;
  gl_.GetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &blocks);
  gl_.GetIntegerv(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, &bindings);
  gl_.GetIntegerv(GL_MAX_COMPUTE_SHARED_MEMORY_SIZE, &shared);
  GLint groups = 0;
  gl_.GetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &groups);
  if (!context_->software()) groups_a_dispatch_ = static_cast<std::uint32_t>(std::max(groups, 65535));
  check();
  storage_buffers_ = std::min(blocks, bindings);
  if (blocks < STORAGE_BUFFERS || bindings < STORAGE_BUFFERS || shared < 32768)
    throw Error(ErrorCode::unavailable, context_->device() + ": " + std::to_string(blocks) +
                                            " storage buffers in a compute program, " + std::to_string(bindings) + " bindings, " +
                                            std::to_string(shared) + " bytes of shared memory; " +
                                            std::to_string(STORAGE_BUFFERS) + ", " + std::to_string(STORAGE_BUFFERS) +
                                            " and 32768 are needed: " + otherwise_);
  set_budget(0);
}

void ComputeDevice::set_budget(std::uint64_t bytes) {
  // A device that is software tells what no file is cached in: next to nothing on a machine that has been busy.
  std::uint64_t most = context_->software() ? 0 : free_bytes(gl_);
  if (most > 0) most += allocated_;  // what is free is what is free beside our own
  const std::uint64_t known = most > 0 ? most - most / 10 : kUnknownBudget;
  budget_ = bytes == 0 ? known : most > 0 ? std::min(bytes, known) : bytes;
}

void ComputeDevice::reserve(ComputeBuffer& buffer, std::uint64_t bytes, const std::string& what) {
  bytes = std::max<std::uint64_t>(64, (bytes + 15) / 16 * 16);
  if (buffer.object && buffer.bytes >= bytes) return;
  free(buffer);
  const auto refuse = [&](const std::string& limit) {
    throw Error(ErrorCode::too_large, context_->device() + ": " + what + " would need " + std::to_string(bytes) + " bytes; " +
                                          limit + ": narrow the intervals or " + otherwise_);
  };
  if (bytes > largest_buffer_) refuse("a buffer of this device holds " + std::to_string(largest_buffer_));
  if (bytes > budget_ - std::min(budget_, allocated_))
    refuse(std::to_string(allocated_) + " of " + std::to_string(budget_) + " are in use");
  check();
  buffer.object = make_buffer(gl_);
  gl_.NamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
  if (const GLenum error = gl_.GetError(); error != GL_NO_ERROR) {
    buffer.object = {};
    if (error == GL_OUT_OF_MEMORY) refuse("the device has no room for them");
    throw Error(ErrorCode::unavailable, context_->device() + ": OpenGL error " + std::to_string(error) + " for a buffer of " +
                                            std::to_string(bytes) + " bytes");
  }
  buffer.bytes = bytes;
  allocated_ += bytes;
}

void ComputeDevice::free(ComputeBuffer& buffer) {
  allocated_ -= buffer.bytes;
  buffer.bytes = 0;
  buffer.object = {};
}

void ComputeDevice::upload(const ComputeBuffer& buffer, std::uint64_t offset, std::span<const std::byte> bytes,
                           const Task& task) {
  for (std::uint64_t at = 0; at < bytes.size(); at += kPiece) {
    task.check();
    const auto piece = bytes.subspan(at, std::min<std::uint64_t>(kPiece, bytes.size() - at));
    gl_.NamedBufferSubData(buffer.name(), static_cast<GLintptr>(offset + at), static_cast<GLsizeiptr>(piece.size()),
                           piece.data());
  }
}

void ComputeDevice::clear(const ComputeBuffer& buffer, std::uint64_t bytes) {
  const std::uint32_t zero = 0;
  gl_.ClearNamedBufferSubData(buffer.name(), GL_R32UI, 0, static_cast<GLsizeiptr>((bytes + 3) / 4 * 4), GL_RED_INTEGER,
                              GL_UNSIGNED_INT, &zero);
  gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void ComputeDevice::read(const ComputeBuffer& buffer, std::uint64_t offset, std::span<std::byte> bytes, const Task& task) {
  finish(task);
  for (std::uint64_t at = 0; at < bytes.size(); at += kPiece) {
    task.check();
    const auto piece = bytes.subspan(at, std::min<std::uint64_t>(kPiece, bytes.size() - at));
    gl_.GetNamedBufferSubData(buffer.name(), static_cast<GLintptr>(offset + at), static_cast<GLsizeiptr>(piece.size()),
                              piece.data());
  }
  check();
}

GLuint ComputeDevice::program(const char* source, const std::string& defines) {
  GlObject& program = programs_[{source, defines}];
  if (!program) program = make_compute_program(gl_, shaders::extraction_glsl, source, defines);
  return program.name();
}

void ComputeDevice::dispatch(GLuint program, std::uint32_t groups, const Task& task) {
  task.check();
  gl_.UseProgram(program);
  gl_.DispatchCompute(groups, 1, 1);
}

void ComputeDevice::dispatch_indirect(GLuint program, const ComputeBuffer& groups, std::uint32_t slice, const Task& task) {
  task.check();
  gl_.UseProgram(program);
  gl_.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, groups.name());
  gl_.DispatchComputeIndirect(static_cast<GLintptr>(slice * sizeof(shaders::WorkGroups)));
}

void ComputeDevice::barrier() {
  gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void ComputeDevice::finish(const Task& task) {
  const GLsync fence = gl_.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  if (!fence) check();
  GLenum state = GL_TIMEOUT_EXPIRED;
  while (fence && state == GL_TIMEOUT_EXPIRED && !task.cancelled())
    state = gl_.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 5'000'000);
  if (fence) gl_.DeleteSync(fence);
  task.check();
  check();
  if (state == GL_WAIT_FAILED) throw Error(ErrorCode::unavailable, context_->device() + ": waiting for the device failed");
}

void ComputeDevice::check() {
  if (gl_.GetGraphicsResetStatus && gl_.GetGraphicsResetStatus() != GL_NO_ERROR)
    throw Error(ErrorCode::unavailable, context_->device() + ": the driver has reset the device");
  const GLenum error = gl_.GetError();
  if (error == GL_NO_ERROR) return;
  if (error == GL_OUT_OF_MEMORY)
    throw Error(ErrorCode::too_large, context_->device() + ": out of memory: narrow the intervals or " + otherwise_);
  if (error == kContextLost) throw Error(ErrorCode::unavailable, context_->device() + ": the context was lost");
  throw Error(ErrorCode::unavailable, context_->device() + ": OpenGL error " + std::to_string(error));
}

ComputeTimer::ComputeTimer(ComputeDevice& device) : device_(device) {
  if (device.context().software()) {
    started_ns_ = now_ns();
    return;
  }
  for (GlObject& query : queries_) query = make_query(device.gl(), GL_TIMESTAMP);
  device.gl().QueryCounter(queries_[0].name(), GL_TIMESTAMP);
}

void ComputeTimer::stop() {
  if (queries_[1]) device_.gl().QueryCounter(queries_[1].name(), GL_TIMESTAMP);
}

double ComputeTimer::elapsed_ms() {
  if (!queries_[1]) return static_cast<double>(now_ns() - started_ns_) * 1e-6;
  GLuint64 ns[2] = {0, 0};
  for (int i = 0; i < 2; ++i) device_.gl().GetQueryObjectui64v(queries_[i].name(), GL_QUERY_RESULT, &ns[i]);
  return static_cast<double>(ns[1] - ns[0]) * 1e-6;
}

}  // namespace isostrata
