#include "base/error.h"
#include "rendering/compute_renderer.h"
#include "rendering/gl_renderer.h"
#include "rendering/native_renderer.h"
#include "rendering/renderer.h"

namespace isostrata {
namespace {

bool hardware_at_hand() {
  for (const DeviceAttempt& attempt : probe_devices())
    if (attempt.ok && !attempt.software) return true;
  return false;
}

}  // namespace

std::unique_ptr<Renderer> make_renderer(const RendererChoice& choice) {
  if (choice.renderer != "auto" && choice.renderer != "native" && choice.renderer != "raster" && choice.renderer != "compute")
    throw Error(ErrorCode::invalid_argument, "renderer '" + choice.renderer + "': expected auto, native, raster or compute");
  if (choice.renderer == "native" ||
      (choice.renderer == "auto" && (choice.device == "native" || (choice.device == "auto" && !hardware_at_hand()))))
    return make_native_renderer();
  if (choice.device == "native")
    throw Error(ErrorCode::invalid_argument, "renderer " + choice.renderer + " draws with OpenGL; the device native has none");
  if (choice.renderer == "compute") return make_compute_renderer(open_context(choice.device), choice.device);
  return make_gl_renderer(open_context(choice.device), choice.device);
}

}  // namespace isostrata
