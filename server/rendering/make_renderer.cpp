#include "base/error.h"
#include "rendering/compute_renderer.h"
#include "rendering/gl_renderer.h"
#include "rendering/native_renderer.h"
#include "rendering/renderer.h"
#include "rendering/renderer_trial.h"

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
  const bool automatic = choice.renderer == "auto";
  if (choice.renderer == "native" ||
      (automatic && (choice.device == "native" || (choice.device == "auto" && !choice.trial && !hardware_at_hand()))))
    return make_native_renderer();
  if (choice.device == "native")
    throw Error(ErrorCode::invalid_argument, "renderer " + choice.renderer + " draws with OpenGL; the device native has none");
  if (choice.renderer == "compute") return make_compute_renderer(open_context(choice.device), choice.device);
  auto context = open_context(choice.device);
  if (automatic && (choice.trial || !context->software())) {
    context.reset();
    return make_faster_renderer(choice.device);
  }
  return make_gl_renderer(std::move(context), choice.device);
}

}  // namespace isostrata
