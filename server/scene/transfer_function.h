// Piecewise-linear transfer functions as intervals.
#pragma once

#include <span>
#include <vector>

#include "scene/scene.h"

namespace isostrata {

/// Touching intervals between neighbouring points, each with a colour ramp and an opacity that runs over its own range. Colour
/// and extinction are then linear inside every tetrahedron, so that the picture of the transfer function is exact. (Extinction,
/// not opacity, is what is linear in between: -ln(1 - opacity) of the two points.) A step is two points of one value. Where both
/// points are wholly transparent there is no interval. Ids count from 1; priorities rise with the value.
/// Throws invalid_argument: fewer than two points, values that are not finite or that fall, colours or opacities outside [0, 1],
/// nothing but transparent or empty parts; too_large: more than max_points.
std::vector<SceneInterval> transfer_intervals(std::span<const TransferPoint> points, std::size_t max_points = 1024);

/// Throws what transfer_intervals does, but takes functions that are wholly transparent.
void check_transfer(std::span<const TransferPoint> points, std::size_t max_points = 1024);

/// The points at the places in [lower, upper] that they have between the first and the last of them, whose values must differ.
/// The ends are met to the last bit, since points of the grid that have them belong to the interval.
std::vector<TransferPoint> moved_transfer(std::span<const TransferPoint> points, double lower, double upper);

/// What stands for the scene when it is drawn: each interval with a transfer function becomes the touching intervals between its
/// points, and each whose colours run with the logarithm its log_parts (scene/color_range.h). They have its id, name, priority and visibility, and at its ends its surfaces. Parts that are wholly transparent are
/// left out where no surface is drawn, but one of them stays where there would be none. What counts intervals (cycles, legends,
/// facts) takes neighbours of one id as one.
Scene drawn_scene(const Scene& scene);

/// The fewest of a table's points between which a straight line stays within `tolerance` of all of its colours and opacities
/// (greedy, from the left); the first and the last are among them.
std::vector<TransferPoint> thin_out(std::span<const TransferPoint> points, double tolerance = 1.0 / 255);

}  // namespace isostrata
