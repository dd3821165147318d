#include "rendering/draw_segments.h"

#include "base/error.h"

namespace isostrata {

struct SegmentsRenderer::State {};
SegmentsRenderer::SegmentsRenderer() = default;
SegmentsRenderer::~SegmentsRenderer() = default;
void SegmentsRenderer::draw(const DrawInput&, TileSink&, DrawFacts&) {
  throw Error(ErrorCode::unavailable, "segments: under construction");
}

}  // namespace isostrata
