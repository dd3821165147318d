// Native drawing of intervals of constant colour and extinction.
#pragma once

#include "rendering/picture/renderer.h"
#include "rendering/tiles/tile_sink.h"

namespace isostrata {

class CrossingsRenderer {
 public:
  CrossingsRenderer();
  ~CrossingsRenderer();
  /// Draws input to the sink and fills facts, except fragments if it has bricks in place of a mesh. Every drawn style is constant(). Parallel;
  /// one caller at a time.
  void draw(const DrawInput& input, TileSink& sink, DrawFacts& facts);

 private:
  struct Facets;
  void draw(const DrawInput& input, const Facets& facets, TileSink& sink, DrawFacts& facts);

  struct State;  // kept from frame to frame
  std::unique_ptr<State> state_;
};

}  // namespace isostrata
