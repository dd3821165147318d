// Drawing in tests.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "rendering/picture/renderer.h"
#include "support/box_mesh.h"
#include "support/test_device.h"

namespace isostrata::testing {

inline constexpr double kHalfStep = 1.0 / 510;  // of 8 bits

/// One renderer for all tests of a thread.
inline Renderer& test_renderer() {
  static const std::unique_ptr<Renderer> renderer = make_renderer({"raster", test_device()});
  return *renderer;
}

inline FloatImage draw_floats(DrawInput input, Renderer& renderer = test_renderer()) {
  input.float_image = true;
  return std::get<FloatImage>(renderer.draw(input).image);
}

inline Image draw_bytes(const DrawInput& input, Renderer& renderer = test_renderer()) {
  return std::get<Image>(renderer.draw(input).image);
}

inline std::array<float, 4> pixel(const FloatImage& image, int x, int y) {
  const auto at = 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  return {image.rgba[at], image.rgba[at + 1], image.rgba[at + 2], image.rgba[at + 3]};
}

inline std::array<int, 4> pixel(const Image& image, int x, int y) {
  const auto at = 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  return {image.rgba[at], image.rgba[at + 1], image.rgba[at + 2], image.rgba[at + 3]};
}

/// The picture's bytes are its floats over the background, or straight with their alpha if it is transparent, to within `step`
/// of 255, colours divided by their alpha to within `straight_step`.
inline void expect_bytes_of_floats(DrawInput input, Renderer& renderer, double step, double straight_step) {
  input.background = {0.2f, 0.4f, 0.6f};
  const FloatImage floats = draw_floats(input, renderer);
  const Image over = draw_bytes(input, renderer);
  input.transparent = true;
  const Image straight = draw_bytes(input, renderer);
  for (int y = 0; y < input.height; ++y)
    for (int x = 0; x < input.width; ++x) {
      const auto f = pixel(floats, x, y);
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(pixel(over, x, y)[c], 255 * (f[c] + (1 - f[3]) * input.background[c]), step);
        if (f[3] > 0.01f) {
          EXPECT_NEAR(pixel(straight, x, y)[c], 255 * f[c] / f[3], straight_step);
        }
      }
      EXPECT_EQ(pixel(over, x, y)[3], 255);
      EXPECT_NEAR(pixel(straight, x, y)[3], 255 * f[3], step);
    }
}

inline IntervalStyle constant_style(Rgb color, double opacity) {
  IntervalStyle style;
  style.color = color;
  style.opacity = opacity;
  return style;
}

/// A mesh with constant styles in red, green, blue, yellow, ..., seen from the three-quarter view.
inline DrawInput input_of(IntervalMesh mesh, double opacity = 0.5) {
  DrawInput input;
  input.bounds = bounds_of(mesh);
  for (std::size_t i = 0; i < mesh.summaries.size(); ++i)
    input.styles.push_back(constant_style(default_interval_color(i), opacity));
  input.mesh = std::make_shared<const IntervalMesh>(std::move(mesh));
  input.camera = view_of(input.bounds, "reset");
  input.width = 64;
  input.height = 48;
  return input;
}

}  // namespace isostrata::testing
