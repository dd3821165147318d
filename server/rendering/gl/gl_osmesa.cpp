// OSMesa, Mesa's off-screen software renderer, for systems whose EGL does not work. Loaded on demand: newer systems have dropped
// it.
#include <dlfcn.h>

#include <array>

#include "base/error.h"
#include "rendering/gl/gl_ways.h"

namespace isostrata {
namespace {

// The few declarations of GL/osmesa.h (Debian: libosmesa6-dev) that are needed.
using OsmesaContext = void*;
constexpr int kOsmesaFormat = 0x22, kOsmesaDepthBits = 0x30, kOsmesaStencilBits = 0x31, kOsmesaAccumBits = 0x32,
              kOsmesaProfile = 0x33, kOsmesaCoreProfile = 0x34, kOsmesaMajor = 0x36, kOsmesaMinor = 0x37;

struct Osmesa {
  OsmesaContext (*CreateContextAttribs)(const int* attributes, OsmesaContext share) = nullptr;
  void (*DestroyContext)(OsmesaContext context) = nullptr;
  unsigned char (*MakeCurrent)(OsmesaContext context, void* buffer, unsigned type, int width, int height) = nullptr;
  void* (*GetProcAddress)(const char* name) = nullptr;
  std::string failure;
};

Osmesa load_osmesa() {
  Osmesa osmesa;
  void* library = nullptr;
  for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6"})
    if (!library) library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    osmesa.failure = "libOSMesa.so.8 and libOSMesa.so.6 cannot be loaded (Debian: libosmesa6, up to 13; Mesa has had none since 25.1)";
    return osmesa;
  }
  const auto find = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    if (!function) osmesa.failure = std::string("libOSMesa lacks ") + name;
  };
  find(osmesa.CreateContextAttribs, "OSMesaCreateContextAttribs");
  find(osmesa.DestroyContext, "OSMesaDestroyContext");
  find(osmesa.MakeCurrent, "OSMesaMakeCurrent");
  find(osmesa.GetProcAddress, "OSMesaGetProcAddress");
  return osmesa;
}

const Osmesa& osmesa() {
  static const Osmesa loaded = load_osmesa();
  return loaded;
}

class OsmesaGlContext : public GlContext {
 public:
  OsmesaGlContext() {
    if (!osmesa().failure.empty()) throw Error(ErrorCode::unavailable, osmesa().failure);
    const int attributes[] = {kOsmesaFormat,
                              GL_RGBA,
                              kOsmesaDepthBits,
                              0,
                              kOsmesaStencilBits,
                              0,
                              kOsmesaAccumBits,
                              0,
                              kOsmesaProfile,
                              kOsmesaCoreProfile,
                              kOsmesaMajor,
                              4,
                              kOsmesaMinor,
                              5,
                              0,
                              0};
    context_ = osmesa().CreateContextAttribs(attributes, nullptr);
    if (!context_) throw Error(ErrorCode::unavailable, "OSMesa makes no OpenGL 4.5 core context");
    try {
      make_current();
      load([](const char* name) { return osmesa().GetProcAddress(name); }, "OSMesa");
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~OsmesaGlContext() override { destroy(); }

 private:
  void destroy() {
    release();
    if (context_) osmesa().DestroyContext(context_);
    context_ = nullptr;
  }
  bool bind() override { return osmesa().MakeCurrent(context_, buffer_.data(), GL_UNSIGNED_BYTE, 4, 4) != 0; }
  void unbind() override { osmesa().MakeCurrent(nullptr, nullptr, 0, 0, 0); }

  OsmesaContext context_ = nullptr;
  std::array<unsigned char, 4 * 4 * 4>
      buffer_{};  // the window that OSMesa insists on; pictures are drawn to framebuffers of our own
};

}  // namespace

std::unique_ptr<GlContext> open_osmesa() { return std::make_unique<OsmesaGlContext>(); }

}  // namespace isostrata
