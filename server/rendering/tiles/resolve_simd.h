// The loops over pixels that end a software renderer's tile, in vectors of what the processor has.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/image.h"
#include "scene/style.h"

namespace isostrata {

/// One row of a tile to bytes R, G, B, A: premultiplied floats over the background, or, where `transparent`, straight colour and
/// alpha; rounded to nearest.
struct ResolveRow {
  const float* rgba[4];
  std::size_t count = 0;
  Rgb background{};
  bool transparent = false;
  std::uint8_t* out = nullptr;
};
void resolve_row(const ResolveRow& row);

/// The same of a whole picture, whose channels lie side by side. Parallel; throws what the pool throws.
Image resolved(const FloatImage& picture, const Rgb& background, bool transparent);

/// depth[i] += unit * sum[i].
void add_scaled(const std::int32_t* sum, float unit, std::size_t count, float* depth);

/// One row of pixels painted with one colour of this optical depth, over what is there. The depth is along the direction of view;
/// the ray of pixel i is longer by sqrt(1 + across + (first + i * step)^2). Nothing happens where the depth is not above 0.
struct PaintRow {
  const float* depth = nullptr;
  std::size_t count = 0;
  float across = 0, first = 0, step = 0;
  Rgb color{};
  float* rgba[4];
};
void paint_row(const PaintRow& row);

}  // namespace isostrata
