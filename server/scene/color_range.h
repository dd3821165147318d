// The range of values that colour maps run over, and its logarithm.
#pragma once

#include "scene/scene.h"
#include "scene/style.h"

namespace isostrata {

/// Where a logarithmic range begins that the data would begin at 0 or below: at this share of its upper end, as ParaView has it.
inline constexpr double kLogFloor = 1e-4;

/// ColorSpan::all_steps becomes these numbers, of the color-by array; if there are none (lower > upper), the step's.
ColorRange resolved(ColorRange range, double lower, double upper);

/// An interval whose colours run with the logarithm becomes touching ones over each of which the value grows no more than
/// sixteenfold (the lowest may reach further down): a colour map over such a part is a smooth function of the value itself, which
/// is what is linear inside a tetrahedron, so that renderers integrate it as exactly as any other map. They have the interval's id
/// and know its ends (SceneInterval::whole).
std::vector<SceneInterval> log_parts(const SceneInterval& interval);

/// Sets the style's map, its range and the opacities at the ends of that.
/// lower, upper: the color-by array's range at the step that is shown. own_array: it is the one that is cut, so that values lie
/// between the interval's ends.
void set_colors(IntervalStyle& style, const SceneInterval& interval, const ColorRange& range, double lower, double upper,
                bool own_array);

/// The range in which the interval's colours run, for the legend; of a logarithmic one lower > 0. lower == upper where there is
/// nothing to run over.
ColorRange colors_shown(const SceneInterval& interval, const ColorRange& range, double lower, double upper);

}  // namespace isostrata
