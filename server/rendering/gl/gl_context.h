// Off-screen OpenGL 4.5 core contexts: EGL devices, EGL surfaceless, OSMesa. EGL and OSMesa are loaded when they are first
// needed, so the program starts, and says what is missing, on a machine that has neither.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rendering/gl/gl_functions.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// A context lives on the thread that made it.
class GlContext {
 public:
  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Makes it current on this thread, whatever was before. Throws unavailable.
  void make_current();
  /// Current no longer, on this thread.
  void release();

  const GlFunctions& gl() const { return gl_; }
  /// So that a test can put in functions that fail as a device's would.
  GlFunctions& gl_to_break() { return gl_; }
  const std::string& device() const { return device_; }  // "llvmpipe (LLVM 15.0.6, 256 bits), EGL surfaceless"
  bool software() const { return software_; }
  const std::string& uuid() const { return uuid_; }  // of the device, lower-case hexadecimal digits; empty if it has none

 protected:
  GlContext() = default;
  virtual bool bind() = 0;
  virtual void unbind() = 0;
  /// Called once the context is current: fills the table, checks the version, reads the names. Throws unavailable.
  void load(void* (*get_function)(const char* name), std::string_view way);

 private:
  GlFunctions gl_;
  std::string device_;
  std::string uuid_;
  bool software_ = false;
};

/// device as make_renderer takes it. Throws unavailable saying what was tried and why each failed, invalid_argument for an
/// unknown name.
std::unique_ptr<GlContext> open_context(std::string_view device);

}  // namespace isostrata
