#include "rendering/check_draw_input.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"

namespace isostrata {
namespace {

bool finite(const Rgb& rgb) {
  return std::all_of(rgb.begin(), rgb.end(), [](float v) { return std::isfinite(v); });
}

}  // namespace

void check(const DrawInput& input) {
  const auto fail = [](const std::string& why) { throw Error(ErrorCode::invalid_argument, "picture: " + why); };
  if (input.width < 1 || input.width > kMaxImageSize || input.height < 1 || input.height > kMaxImageSize)
    fail("size " + std::to_string(input.width) + "x" + std::to_string(input.height) + ", expected 1 to " +
         std::to_string(kMaxImageSize) + " pixels each way");
  check(input.camera);
  if (!std::isfinite(input.unit_distance) || input.unit_distance < 0) fail("unit distance must be a finite number, 0 or above");
  if (!finite(input.background)) fail("the background is not a colour");
  if (!input.mesh) fail("no mesh");
  const std::size_t intervals = input.cut_intervals.empty() ? input.mesh->summaries.size() : input.cut_intervals.size();
  if (input.styles.size() != intervals)
    fail(std::to_string(input.styles.size()) + " styles for " + std::to_string(intervals) + " intervals");
  if (!input.cut_intervals.empty() && (!input.color_values || input.color_values->size() != input.mesh->positions.size()))
    fail("intervals that the renderer cuts need the field's values on the mesh's " +
         std::to_string(input.mesh->positions.size()) + " points");
  for (const Interval& interval : input.cut_intervals)
    if (!(interval.lower < interval.upper)) fail("an interval's lower end must be below its upper end");
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    const IntervalStyle& style = input.styles[i];
    const std::string which = "interval " + std::to_string(i) + ": ";
    if (!finite(style.color)) fail(which + "its colour is not a number");
    if (!(style.opacity >= 0 && style.opacity <= 1)) fail(which + "opacity must be in [0, 1]");
    if (style.color_map.empty()) continue;
    color_map(style.color_map);  // throws where there is no such map
    if (!std::isfinite(style.color_lower) || !std::isfinite(style.color_upper))
      fail(which + "the colour map's range is not finite");
    if (!input.color_values || input.color_values->size() != input.mesh->positions.size())
      fail(which + "a colour map needs one value for each of the mesh's " + std::to_string(input.mesh->positions.size()) +
           " points");
  }
}

}  // namespace isostrata
