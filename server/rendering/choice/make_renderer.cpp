#include "base/error.h"
#include "rendering/choice/device_or_native.h"
#include "rendering/choice/native_renderer.h"
#include "rendering/choice/quicker_renderer.h"
#include "rendering/choice/renderer_trial.h"
#include "rendering/compute/compute_renderer.h"
#include "rendering/gl/gl_probe.h"
#include "rendering/gl/graphics_cards.h"
#include "rendering/picture/renderer.h"
#include "rendering/raster/gl_renderer.h"

namespace isostrata {
namespace {

bool hardware_at_hand() {
  if (!may_draw_with_card()) return false;
  const DeviceAttempt* taken = automatic_device();
  return taken && !taken->software;
}

std::unique_ptr<Renderer> make_volume_renderer(const RendererChoice& choice) {
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

}  // namespace

std::unique_ptr<Renderer> make_renderer(const RendererChoice& choice) {
  auto renderer = make_volume_renderer(choice);
  if (renderer->cuts_intervals()) return renderer;  // the native one
  renderer = make_device_or_native(std::move(renderer));
  return choice.renderer == "auto" && !choice.trial && choice.device == "auto" ? make_quicker_renderer(std::move(renderer)) : std::move(renderer);
}

}  // namespace isostrata
