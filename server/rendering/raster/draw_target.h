// What is drawn into: a float target for one tile of the picture, its resolve to 8 bits, and reading both back.
#pragma once

#include <functional>
#include <string>

#include "base/image.h"
#include "rendering/gl/gl_objects.h"
#include "scene/style.h"

namespace isostrata {

/// A part of the picture.
struct Tile {
  int x = 0, y = 0;  // of its lower left pixel, counted from the picture's lower left
  int width = 0, height = 0;
};

/// Kept from frame to frame; remade where the size changes. The context must be current in every call.
class DrawTarget {
 public:
  explicit DrawTarget(const GlFunctions& gl);

  /// Makes it ready for a tile, black and clear, and binds it; nearest, mean: with the second attachment for depth, the third for
  /// mean depth. Throws too_large, unavailable.
  void begin(const Tile& tile, bool nearest, bool mean);
  /// What is drawn into is not kept any longer.
  void give_back();
  /// To 8 bits, on the device: over the background, or straight colours with their alpha.
  void resolve(const Rgb& background, bool transparent);
  /// After resolve(): the tile's pixels of the picture.
  void read(const Tile& tile, Image& image) const;
  /// Instead of resolve(). depth_of: the depth in world units of what the second attachment holds, where that is above 0; scale: what
  /// the third one's is times that.
  void read(const Tile& tile, const std::function<double(double)>& depth_of, double scale, FloatImage& image) const;

 private:
  void make(int width, int height, bool nearest, bool mean);

  const GlFunctions& gl_;
  int width_ = 0, height_ = 0;
  GlObject color_, nearest_, mean_, bytes_;  // RGBA32F, R32F twice (only where such a depth is wanted), RGBA8
  GlObject accumulate_, resolve_;            // framebuffers
  GlObject resolve_program_, vertex_array_;  // the resolve triangle has no attributes
};

}  // namespace isostrata
