#include "engine/picture/draw_lit.h"

#include <utility>

#include "base/stopwatch.h"
#include "rendering/light/light_rows.h"
#include "rendering/tiles/resolve_simd.h"

namespace isostrata {

DrawResult draw_lit(Renderer& renderer, const DrawInput& input, const DepthLight& light) {
  if (!light.any()) return renderer.draw(input);
  LightRows rows(light, input);
  DrawInput floats = input;
  floats.mean_depth = true;
  floats.rounded = input.rounded || !input.float_image;
  floats.float_image = true;
  DrawResult result = renderer.draw(floats);
  const Stopwatch watch;
  FloatImage lit = rows.add(std::move(std::get<FloatImage>(result.image)));
  if (input.float_image)
    result.image = std::move(lit);
  else
    result.image = resolved(lit, input.background, input.transparent);
  const double ms = watch.elapsed_ms();
  result.facts.draw_ms += ms;
  result.facts.stages.push_back({"light", ms});
  return result;
}

}  // namespace isostrata
