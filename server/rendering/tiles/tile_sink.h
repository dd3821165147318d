// Where a software renderer's finished tiles go.
#pragma once

#include <cstddef>

#include "rendering/picture/renderer.h"

namespace isostrata {

/// A finished part of the picture: planes of premultiplied colour and alpha. Row 0 is the top row; row y of a plane begins at
/// y * stride.
struct FinishedTile {
  int x = 0, y = 0;  // of its upper left pixel in the picture
  int width = 0, height = 0;
  std::size_t stride = 0;
  const float* rgba[4] = {};
  const float* depth = nullptr;  // world units along the view direction, infinity where nothing was drawn; where wants_depth()
  const float* mean_depth = nullptr;  // FloatImage::mean_depth; where wants_mean_depth()
};

/// Makes the picture that the input asks for and fills it tile by tile: 8 bits over the background, 8 bits with straight alpha,
/// or the floats as they are.
class TileSink {
 public:
  explicit TileSink(const DrawInput& input);

  bool wants_depth() const { return wants_depth_; }
  bool wants_mean_depth() const { return wants_mean_depth_; }
  /// The picture becomes 8 bits, here or later.
  bool rounded() const { return rounded_; }
  /// Any thread; tiles must not overlap.
  void put(const FinishedTile& tile);
  std::variant<Image, FloatImage> take() { return std::move(image_); }

 private:
  Rgb background_;
  bool transparent_, wants_depth_, wants_mean_depth_, rounded_;
  std::variant<Image, FloatImage> image_;
};

}  // namespace isostrata
