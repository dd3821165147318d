// EGL 1.5 with EGL_EXT_device_enumeration, EGL_EXT_platform_device, EGL_MESA_platform_surfaceless. libEGL is opened once and its
// displays are never terminated: a display is one per process and device, and terminating it would end every other context on it.
#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <atomic>
#include <cstdio>
#include <string_view>

#include "base/error.h"
#include "rendering/gl/gl_ways.h"
#include "rendering/gl/graphics_cards.h"

namespace isostrata {
namespace {

constexpr EGLint kDeviceUuidExt = 0x335C;         // EGL_DEVICE_UUID_EXT of EGL_EXT_device_persistent_id
constexpr EGLint kContextResetStrategy = 0x31BD;  // EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY (EGL 1.5)
constexpr EGLint kLoseContextOnReset = 0x31BF;    // EGL_LOSE_CONTEXT_ON_RESET

using QueryDeviceBinary = EGLBoolean (*)(EGLDeviceEXT device, EGLint name, EGLint max_size, void* value, EGLint* size);

struct Egl {
  void* library = nullptr;
  decltype(&::eglGetProcAddress) GetProcAddress = nullptr;
  decltype(&::eglQueryString) QueryString = nullptr;
  decltype(&::eglInitialize) Initialize = nullptr;
  decltype(&::eglBindAPI) BindAPI = nullptr;
  decltype(&::eglChooseConfig) ChooseConfig = nullptr;
  decltype(&::eglCreateContext) CreateContext = nullptr;
  decltype(&::eglDestroyContext) DestroyContext = nullptr;
  decltype(&::eglMakeCurrent) MakeCurrent = nullptr;
  decltype(&::eglGetError) GetError = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplayEXT = nullptr;
  PFNEGLQUERYDEVICESEXTPROC QueryDevicesEXT = nullptr;            // may be null
  PFNEGLQUERYDEVICESTRINGEXTPROC QueryDeviceStringEXT = nullptr;  // may be null
  QueryDeviceBinary QueryDeviceBinaryEXT = nullptr;               // may be null
  std::string failure;                                            // why it cannot be used; empty if it can
};

bool has_word(const char* list, std::string_view word) {
  std::string_view rest = list ? list : "";
  while (!rest.empty()) {
    const auto end = rest.find(' ');
    if (rest.substr(0, end) == word) return true;
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  return false;
}

std::atomic<bool> loaded{false};

Egl load_egl() {
  loaded = true;
  Egl egl;
  egl.library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!egl.library) {
    const char* why = dlerror();
    egl.failure = std::string("libEGL.so.1 cannot be loaded: ") + (why ? why : "unknown reason");
    return egl;
  }
  bool complete = true;
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(egl.library, name));
    complete = complete && function != nullptr;
  };
  find(egl.GetProcAddress, "eglGetProcAddress");
  find(egl.QueryString, "eglQueryString");
  find(egl.Initialize, "eglInitialize");
  find(egl.BindAPI, "eglBindAPI");
  find(egl.ChooseConfig, "eglChooseConfig");
  find(egl.CreateContext, "eglCreateContext");
  find(egl.DestroyContext, "eglDestroyContext");
  find(egl.MakeCurrent, "eglMakeCurrent");
  find(egl.GetError, "eglGetError");
  if (!complete) {
    egl.failure = "libEGL.so.1 lacks functions of EGL 1.4";
    return egl;
  }
  const auto extension = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(egl.GetProcAddress(name));
  };
  extension(egl.GetPlatformDisplayEXT, "eglGetPlatformDisplayEXT");
  const char* client = egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (has_word(client, "EGL_EXT_device_enumeration") || has_word(client, "EGL_EXT_device_base"))
    extension(egl.QueryDevicesEXT, "eglQueryDevicesEXT");
  if (has_word(client, "EGL_EXT_device_query") || has_word(client, "EGL_EXT_device_base"))
    extension(egl.QueryDeviceStringEXT, "eglQueryDeviceStringEXT");
  extension(egl.QueryDeviceBinaryEXT, "eglQueryDeviceBinaryEXT");
  if (!egl.GetPlatformDisplayEXT) egl.failure = "EGL lacks EGL_EXT_platform_base";
  return egl;
}

const Egl& egl() {
  static const Egl egl = load_egl();
  return egl;
}

std::string error_text() {
  char text[32];
  std::snprintf(text, sizeof text, "EGL error 0x%04x", static_cast<unsigned>(egl().GetError()));
  return text;
}

class EglContext : public GlContext {
 public:
  EglContext(EGLDisplay display, const char* display_extensions, std::string_view way) : display_(display) {
    if (!egl().BindAPI(EGL_OPENGL_API)) throw Error(ErrorCode::unavailable, "no desktop OpenGL: " + error_text());
    if (!has_word(display_extensions, "EGL_KHR_surfaceless_context"))
      throw Error(ErrorCode::unavailable, "no EGL_KHR_surfaceless_context");
    create(display_extensions);
    if (context_ == EGL_NO_CONTEXT) throw Error(ErrorCode::unavailable, "no OpenGL 4.5 core context: " + error_text());
    try {
      make_current();
      load([](const char* name) { return reinterpret_cast<void*>(egl().GetProcAddress(name)); }, way);
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~EglContext() override { destroy(); }

 private:
  void create(const char* extensions) {
    EGLConfig config = nullptr;  // EGL_NO_CONFIG_KHR
    if (!has_word(extensions, "EGL_KHR_no_config_context")) {
      const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_NONE};
      EGLint count = 0;
      if (!egl().ChooseConfig(display_, wanted, &config, 1, &count) || count == 0)
        throw Error(ErrorCode::unavailable, "no configuration with desktop OpenGL");
    }
    const EGLint plain[] = {
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    const EGLint robust[] = {EGL_CONTEXT_MAJOR_VERSION,
                             4,
                             EGL_CONTEXT_MINOR_VERSION,
                             5,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                             kContextResetStrategy,
                             kLoseContextOnReset,
                             EGL_NONE};
    context_ = egl().CreateContext(display_, config, EGL_NO_CONTEXT, robust);  // a lost context is then reported, not undefined
    if (context_ == EGL_NO_CONTEXT) context_ = egl().CreateContext(display_, config, EGL_NO_CONTEXT, plain);
  }
  void destroy() {
    release();
    if (context_ != EGL_NO_CONTEXT) egl().DestroyContext(display_, context_);
    context_ = EGL_NO_CONTEXT;
  }
  bool bind() override {
    return egl().BindAPI(EGL_OPENGL_API) && egl().MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
  }
  void unbind() override { egl().MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

std::unique_ptr<GlContext> open_display(EGLenum platform, void* native, std::string_view way) {
  if (!egl().failure.empty()) throw Error(ErrorCode::unavailable, egl().failure);
  const EGLDisplay display = egl().GetPlatformDisplayEXT(platform, native, nullptr);
  if (display == EGL_NO_DISPLAY) throw Error(ErrorCode::unavailable, "no display: " + error_text());
  EGLint major = 0, minor = 0;
  if (!egl().Initialize(display, &major, &minor))
    throw Error(ErrorCode::unavailable, "the display cannot be initialized: " + error_text());
  return std::make_unique<EglContext>(display, egl().QueryString(display, EGL_EXTENSIONS), way);
}

/// " (/dev/dri/renderD128, 0000:65:00.0, 1002:73bf, driver amdgpu)"
std::string name_in_brackets(const std::vector<GraphicsCard>& cards, const std::string& file, const EglDevice& device) {
  std::string words = device.software ? "software" : file;
  if (const GraphicsCard* card = device.software ? nullptr : card_of(cards, file, device.uuid)) words += (words.empty() ? "" : ", ") + description(*card);
  return words.empty() ? "" : " (" + words + ")";
}

}  // namespace

bool egl_is_loaded() { return loaded; }

std::string format_uuid(const unsigned char* bytes) {
  std::string text;
  bool zero = true;
  for (int i = 0; i < 16; ++i) {
    char hex[3];
    std::snprintf(hex, sizeof hex, "%02x", bytes[i]);
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += hex;
    zero = zero && bytes[i] == 0;
  }
  return zero ? std::string{} : text;
}

std::vector<EglDevice> egl_devices(std::vector<DeviceAttempt>& attempts) {
  const auto give_up = [&](const std::string& why) {
    attempts.push_back({"EGL devices", false, why, false, ""});
    return std::vector<EglDevice>{};
  };
  if (!egl().failure.empty()) return give_up(egl().failure);
  if (!egl().QueryDevicesEXT || !egl().QueryDeviceStringEXT)
    return give_up("EGL lacks EGL_EXT_device_enumeration or EGL_EXT_device_query");
  EGLDeviceEXT handles[64];
  EGLint count = 0;
  if (!egl().QueryDevicesEXT(64, handles, &count)) return give_up("they cannot be listed: " + error_text());
  if (count == 0) return give_up("none");
  const std::vector<GraphicsCard> cards = graphics_cards();
  std::vector<EglDevice> devices;
  for (EGLint i = 0; i < count; ++i) {
    EglDevice device;
    device.index = i;
    device.handle = handles[i];
    device.name = "EGL device " + std::to_string(i);
    const char* extensions = egl().QueryDeviceStringEXT(handles[i], EGL_EXTENSIONS);
    device.software = has_word(extensions, "EGL_MESA_device_software");
    const char* file = nullptr;
    if (has_word(extensions, "EGL_EXT_device_drm")) file = egl().QueryDeviceStringEXT(handles[i], EGL_DRM_DEVICE_FILE_EXT);
    if (has_word(extensions, "EGL_EXT_device_persistent_id") && egl().QueryDeviceBinaryEXT) {
      unsigned char bytes[16] = {};
      EGLint size = 0;
      if (egl().QueryDeviceBinaryEXT(handles[i], kDeviceUuidExt, sizeof bytes, bytes, &size) && size == 16)
        device.uuid = format_uuid(bytes);
    }
    device.name += name_in_brackets(cards, file ? file : "", device);
    devices.push_back(device);
  }
  return devices;
}

std::unique_ptr<GlContext> open_egl(const EglDevice& device) {
  return open_display(EGL_PLATFORM_DEVICE_EXT, device.handle, device.name);
}

std::unique_ptr<GlContext> open_surfaceless() {
  if (egl().failure.empty() && !has_word(egl().QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_MESA_platform_surfaceless"))
    throw Error(ErrorCode::unavailable, "EGL lacks EGL_MESA_platform_surfaceless (Debian: libegl-mesa0)");
  return open_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, "EGL surfaceless");
}

}  // namespace isostrata
