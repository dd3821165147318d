// The ways to a context, each in its own file: gl_egl.cpp, gl_osmesa.cpp.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rendering/gl/gl_context.h"

namespace isostrata {

struct EglDevice {
  int index = 0;
  void* handle = nullptr;  // EGLDeviceEXT
  std::string name;        // "EGL device 0 (/dev/dri/renderD128)"
  std::string uuid;        // where EGL can tell it without a context
  bool software = false;   // the driver says so itself (EGL_MESA_device_software)
};

/// In the driver's order. Where they cannot be listed, adds an attempt that says why and returns none.
std::vector<EglDevice> egl_devices(std::vector<DeviceAttempt>& attempts);

/// Whether this process has begun to use EGL. Any thread.
bool egl_is_loaded();

// Each throws unavailable with the reason.
std::unique_ptr<GlContext> open_egl(const EglDevice& device);
std::unique_ptr<GlContext> open_surfaceless();
std::unique_ptr<GlContext> open_osmesa();

/// 16 bytes as 8-4-4-4-12 hexadecimal digits; empty if all are zero.
std::string format_uuid(const unsigned char* bytes);

}  // namespace isostrata
