#include "rendering/draw_crossings.h"

#include "base/error.h"

namespace isostrata {

struct CrossingsRenderer::State {};
CrossingsRenderer::CrossingsRenderer() = default;
CrossingsRenderer::~CrossingsRenderer() = default;
void CrossingsRenderer::draw(const DrawInput&, TileSink&, DrawFacts&) {
  throw Error(ErrorCode::unavailable, "crossings: under construction");
}

}  // namespace isostrata
