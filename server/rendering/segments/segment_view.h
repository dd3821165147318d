// How the world reaches the pixels of the native renderer for segments.
//
// Every ray is met in the coordinates (x, y, q): x and y in pixels, y down, the middles of pixels at whole numbers, q growing
// towards the eye. In perspective q = 1 / depth, with an orthographic camera q = a constant - depth; planes of the world are
// planes in (x, y, q) both ways, and tetrahedra are tetrahedra. Lengths are divided by `scale` first, so that the arithmetic does
// not depend on the data's units.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// A point of the mesh on the screen. Of a point that is nearer than near_depth or beyond the guard x is NaN and y says why.
struct SegmentVertex {
  float x = 0, y = 0, q = 0;
  float value = 0;  // of the color-by array
};
inline constexpr float kTooNearToSee = 1, kBeyondTheGuard = 2;

/// Rays are met this little off the pixels' middles, in parts of the larger side of the picture, so that faces that are seen
/// edge-on in straight views of regular grids do not lie on the rays, where either neighbour or none might own them. A few times
/// the step of single precision there.
inline constexpr double kRayShiftX = 1.0 / (1 << 22), kRayShiftY = 0.618 / (1 << 22);

struct SegmentView {
  int width = 1, height = 1;
  bool orthographic = false;
  double scale = 1;                   // world units
  double focal = 1;                   // pixels; of an orthographic camera pixels per unit of scale
  double center_x = 0, center_y = 0;  // pixels: where the line of view meets the picture
  double near_depth = 1e-4;           // of perspective
  double guard = 512;                 // pixels from the centre; what reaches beyond is cut there
  double zero_q_depth = 0;            // orthographic: q = zero_q_depth - depth
  Vec3d eye, right, up, forward;      // world, unit length

  /// x right, y up, z away from the eye, in units of scale.
  Vec3d seen(Vec3d world) const {
    const Vec3d p = world - eye;
    return Vec3d{dot(right, p), dot(up, p), dot(forward, p)} / scale;
  }
  SegmentVertex screen(Vec3d seen_from_eye, double value) const;
  /// World units.
  double depth_of(double q) const { return scale * (orthographic ? zero_q_depth - q : 1 / q); }
};

SegmentView make_segment_view(const DrawInput& input);

/// What a clip plane leaves of pixel (x, y): q >= or <= (at + per_x * x + per_y * y).
struct ScreenHalfSpace {
  double at = 0, per_x = 0, per_y = 0;
  bool keeps_nearer = true;  // q >=
};
ScreenHalfSpace on_screen(const ClipPlane& plane, const SegmentView& view);

}  // namespace isostrata
