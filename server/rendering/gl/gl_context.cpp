#include "rendering/gl/gl_context.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "base/error.h"
#include "rendering/gl/gl_probe.h"
#include "rendering/gl/gl_ways.h"

namespace isostrata {
namespace {

thread_local GlContext* current = nullptr;

constexpr GLenum kDeviceUuid = 0x9597;  // GL_DEVICE_UUID_EXT of GL_EXT_memory_object

bool is_software(std::string_view renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "Software", "SWR"})
    if (renderer.find(name) != std::string_view::npos) return true;
  return false;
}

std::string read_uuid(const GlFunctions& gl) {
  if (!gl.GetUnsignedBytei_vEXT) return {};
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  bool known = false;
  for (GLint i = 0; i < count; ++i)
    known = known || std::string_view(reinterpret_cast<const char*>(gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i)))) ==
                         "GL_EXT_memory_object";
  if (!known) return {};
  GLubyte bytes[16] = {};
  gl.GetUnsignedBytei_vEXT(kDeviceUuid, 0, bytes);
  while (gl.GetError() != GL_NO_ERROR) {
  }
  return format_uuid(bytes);
}

std::string digits_only(std::string_view uuid) {
  std::string digits;
  for (const char c : uuid)
    if (std::isxdigit(static_cast<unsigned char>(c))) digits += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return digits;
}

[[noreturn]] void nothing_opened(std::string_view device, const std::vector<DeviceAttempt>& attempts) {
  std::string text = "no OpenGL 4.5 device for '" + std::string(device) + "'";
  for (const DeviceAttempt& a : attempts) text += "; " + a.name + ": " + (a.ok ? "works: " : "") + a.detail;
  throw Error(ErrorCode::unavailable, text);
}

/// Null: it does not work, and that is written down.
std::unique_ptr<GlContext> attempt(std::vector<DeviceAttempt>& attempts, const EglDevice& device) {
  try {
    return open_egl(device);
  } catch (const Error& error) {
    attempts.push_back({device.name, false, error.what(), false, ""});
    return nullptr;
  }
}

std::unique_ptr<GlContext> open_egl_device(std::string_view device, std::string_view which) {
  std::vector<DeviceAttempt> attempts;
  const std::vector<EglDevice> devices = egl_devices(attempts);
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(which.data(), which.data() + which.size(), index);
  if (error == std::errc{} && end == which.data() + which.size() && which.size() < 10) {
    if (index < devices.size())
      if (auto context = attempt(attempts, devices[index])) return context;
    throw Error(ErrorCode::unavailable,
                "device '" + std::string(device) + "': " +
                    (attempts.empty() ? "no such EGL device; there are " + std::to_string(devices.size()) +
                                            ", counted from 0 (isostrata doctor lists them)"
                                      : attempts.back().name + ": " + attempts.back().detail));
  }
  const std::string wanted = digits_only(which);
  if (wanted.size() != 32)
    throw Error(ErrorCode::invalid_argument,
                "device '" + std::string(device) + "': expected egl:INDEX or egl:UUID (32 hexadecimal digits)");
  for (const EglDevice& candidate : devices) {
    if (!candidate.uuid.empty() && digits_only(candidate.uuid) != wanted) continue;
    auto context = attempt(attempts, candidate);
    if (context && (digits_only(candidate.uuid) == wanted || digits_only(context->uuid()) == wanted)) return context;
    if (context) attempts.push_back({candidate.name, true, context->device() + ", UUID " + context->uuid(), false, ""});
  }
  nothing_opened(device, attempts);
}

}  // namespace

void GlContext::make_current() {
  if (current == this) return;
  if (current) current->release();
  if (!bind()) throw Error(ErrorCode::unavailable, device_ + ": the context cannot be made current");
  current = this;
}

void GlContext::release() {
  if (current != this) return;
  unbind();
  current = nullptr;
}

void GlContext::load(void* (*get_function)(const char* name), std::string_view way) {
  std::string missing;
#define ISOSTRATA_GL_LOAD(type, name)                          \
  gl_.name = reinterpret_cast<type>(get_function("gl" #name)); \
  if (!gl_.name) missing += (missing.empty() ? "gl" : ", gl") + std::string(#name);
  ISOSTRATA_GL_FUNCTIONS(ISOSTRATA_GL_LOAD)
#undef ISOSTRATA_GL_LOAD
  if (!missing.empty()) throw Error(ErrorCode::unavailable, "the driver has no " + missing);
  gl_.GetGraphicsResetStatus = reinterpret_cast<PFNGLGETGRAPHICSRESETSTATUSPROC>(get_function("glGetGraphicsResetStatus"));
  gl_.GetUnsignedBytei_vEXT = reinterpret_cast<decltype(gl_.GetUnsignedBytei_vEXT)>(get_function("glGetUnsignedBytei_vEXT"));
  const auto text = [&](GLenum name) {
    const GLubyte* string = gl_.GetString(name);
    return std::string(string ? reinterpret_cast<const char*>(string) : "");
  };
  GLint major = 0, minor = 0;
  gl_.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl_.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (major * 10 + minor < 45)
    throw Error(ErrorCode::unavailable,
                "OpenGL " + std::to_string(major) + "." + std::to_string(minor) + ", expected 4.5 or newer");
  const std::string renderer = text(GL_RENDERER);
  software_ = is_software(renderer);
  device_ = renderer + ", OpenGL " + std::to_string(major) + "." + std::to_string(minor) + ", " + std::string(way) +
            (software_ ? " (SOFTWARE: no GPU is used)" : "");
  uuid_ = read_uuid(gl_);
}

std::unique_ptr<GlContext> open_context(std::string_view device) {
  if (device == "auto") {
    const DeviceAttempt* taken = automatic_device();
    if (!taken) nothing_opened(device, automatic_attempts());
    return open_context(taken->device);
  }
  if (device.starts_with("egl:")) return open_egl_device(device, device.substr(4));
  if (device != "surfaceless" && device != "osmesa")
    throw Error(ErrorCode::invalid_argument,
                "device '" + std::string(device) + "' is not known; expected auto, egl:INDEX, egl:UUID, surfaceless or osmesa");
  const bool surfaceless = device == "surfaceless";
  try {
    return surfaceless ? open_surfaceless() : open_osmesa();
  } catch (const Error& error) {
    nothing_opened(device, {{surfaceless ? "EGL surfaceless" : "OSMesa", false, error.what(), false, ""}});
  }
}

}  // namespace isostrata
