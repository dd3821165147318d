// Native drawing of intervals whose colour or extinction runs with an array.
#pragma once

#include "rendering/picture/renderer.h"
#include "rendering/tiles/tile_sink.h"

namespace isostrata {

class SegmentsRenderer {
 public:
  SegmentsRenderer();
  ~SegmentsRenderer();
  /// Draws input to the sink and fills facts. Any styles. Parallel; one caller at a time.
  void draw(const DrawInput& input, TileSink& sink, DrawFacts& facts);

 private:
  struct State;  // kept from frame to frame
  std::unique_ptr<State> state_;
};

}  // namespace isostrata
