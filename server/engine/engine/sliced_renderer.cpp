#include "engine/engine/sliced_renderer.h"

#include <algorithm>
#include <variant>
#include <vector>

#include "engine/picture/draw_still.h"

namespace isostrata {
namespace {

template <class T>
void append(std::vector<T>& rows, const std::vector<T>& more, std::size_t all) {
  rows.reserve(more.empty() ? 0 : all);
  rows.insert(rows.end(), more.begin(), more.end());
}

/// all: the pixels of the whole picture.
void append(Image& whole, const Image& rows, std::size_t all) { append(whole.rgba, rows.rgba, 4 * all); }
void append(FloatImage& whole, const FloatImage& rows, std::size_t all) {
  append(whole.rgba, rows.rgba, 4 * all);
  append(whole.depth, rows.depth, all);
  append(whole.mean_depth, rows.mean_depth, all);
}

}  // namespace

DrawResult SlicedRenderer::draw_slice(const DrawInput& slice) {
  if (!std::exchange(is_first_, false)) between_();
  return of_.draw(slice);
}

DrawResult SlicedRenderer::draw(const DrawInput& input) {
  const int rows = static_cast<int>(std::clamp<std::int64_t>(slice_samples_ / std::max(1, input.width), 1, std::max(1, input.height)));
  if (rows >= input.height) return draw_slice(input);
  DrawInput slice = input;
  if (input.window.width == 0) slice.window = {0, 0, input.width, input.height};
  const std::size_t pixels = static_cast<std::size_t>(input.width) * static_cast<std::size_t>(input.height);
  DrawResult whole;
  for (int y = 0; y < input.height; y += rows) {
    slice.window.y = input.window.y + y;
    slice.height = std::min(rows, input.height - y);
    DrawResult drawn = draw_slice(slice);
    add_part(whole.facts, drawn.facts);
    std::visit(
        [&]<class Picture>(Picture& part) {
          if (y == 0) whole.image = Picture{input.width, input.height, {}};
          append(std::get<Picture>(whole.image), part, pixels);
        },
        drawn.image);
  }
  return whole;
}

}  // namespace isostrata
