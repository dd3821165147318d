// Lights a finished picture by its depth: ambient occlusion and a fade into the background. One pass over floats, the same for
// every renderer.
//
// The depth of a pixel is FloatImage::mean_depth over alpha, so that what is seen counts and a faint skin in front of it hardly
// does. Occlusion compares each pixel with pairs of neighbours that lie opposite to one another, up to kOcclusionRadius of
// the picture's height away: of a plane, however it is tilted, one is as much nearer as the other is farther. What is nearer or
// farther by more than two radii counts less, from four on nothing, so that an object has no halo on what lies far behind it.
// Pairs count by both alphas: the background darkens nothing. The sum darkens colours and leaves alpha.
// The fade runs from the nearest corner of the data's bounds to the farthest and takes from colour and alpha alike, so that any
// background comes through. It does not depend on what is drawn: a moved interval does not make the rest brighter.
#pragma once

#include <cstddef>
#include <vector>

#include "base/image.h"
#include "rendering/picture/renderer.h"
#include "scene/depth_light.h"

namespace isostrata {

inline constexpr double kOcclusionRadius = 0.05;   // of the picture's height
inline constexpr double kDarkestOcclusion = 0.8;   // what the strongest takes away at most

/// A pair of neighbours: pixels (x + dx, y + dy) and (x - dx, y - dy).
struct OcclusionPair {
  int dx = 0, dy = 0;
  double weight = 0;  // those of all pairs have the sum kOcclusionGain
};
/// Of a picture of this height: in a spiral, denser and heavier towards the middle.
std::vector<OcclusionPair> occlusion_pairs(int height);

/// Where the fade begins and ends: depths in world units of the bounds' corners. Nothing lies before the eye of a perspective.
struct DepthSpan {
  double nearest = 0, farthest = 0;
};
DepthSpan depth_span(const Box3d& bounds, const Camera& camera);

/// Rows come from the top, with mean_depth; they leave as soon as the rows below that they depend on are there. What is lit does
/// not depend on how the rows come. Calls come from one thread, the work is spread over the pool; throws what the pool throws.
class LightRows {
 public:
  /// whole: the picture's size and camera, and the data's bounds; its window is not looked at. Throws invalid_argument for a light that is not
  /// in [0, 1].
  LightRows(const DepthLight& light, const DrawInput& whole);

  /// The next rows. Returns those that are finished, maybe none; after the picture's last row all the rest.
  FloatImage add(FloatImage&& rows);

  /// Of the rows that wait, for each column, at most: 20 bytes a pixel.
  int margin() const { return margin_; }

 private:
  void add_depths(const FloatImage& rows);
  void light(int begin, int end);

  int width_, height_, margin_ = 0;
  DepthLight light_;
  std::vector<OcclusionPair> pairs_;
  double radius_ = 1;  // of the occlusion in world units; in perspective at depth 1
  bool perspective_;
  DepthSpan span_;
  std::size_t stride_;
  int taken_ = 0, done_ = 0, first_kept_ = 0;  // rows: that came, that left, of which depths are kept
  std::vector<float> depth_, alpha_;           // of the rows from first_kept_ on, with a margin on both sides
  std::vector<float> nothing_;                 // a row outside the picture
  FloatImage waiting_;                         // the rows from done_ on
};

}  // namespace isostrata
