// Piecewise-linear transfer functions as intervals.
#pragma once

#include <span>
#include <vector>

#include "engine/scene.h"

namespace isostrata {

/// A control point: what the field looks like where it has this value.
struct TransferPoint {
  double value = 0;
  Rgb color{1, 1, 1};
  double opacity = 0;  // of a layer one unit distance thick, in [0, 1]

  bool operator==(const TransferPoint&) const = default;
};

/// Touching intervals between neighbouring points, each with a colour ramp and an opacity that runs over its own range. Colour
/// and extinction are then linear inside every tetrahedron, so that the picture of the transfer function is exact. (Extinction,
/// not opacity, is what is linear in between: -ln(1 - opacity) of the two points.) A step is two points of one value. Where both
/// points are wholly transparent there is no interval. Ids count from 1; priorities rise with the value.
/// Throws invalid_argument: fewer than two points, values that are not finite or that fall, colours or opacities outside [0, 1],
/// nothing but transparent or empty parts; too_large: more than max_points.
std::vector<SceneInterval> transfer_intervals(std::span<const TransferPoint> points, std::size_t max_points = 1024);

/// The fewest of a table's points between which a straight line stays within `tolerance` of all of its colours and opacities
/// (greedy, from the left); the first and the last are among them.
std::vector<TransferPoint> thin_out(std::span<const TransferPoint> points, double tolerance = 1.0 / 255);

}  // namespace isostrata
