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
  if (const PictureWindow& window = input.window; window.width != 0 || window.height != 0) {
    if (window.width < 1 || window.width > kMaxWholeSize || window.height < 1 || window.height > kMaxWholeSize || window.x < 0 ||
        window.y < 0 || window.x > window.width - input.width || window.y > window.height - input.height)
      fail(std::to_string(input.width) + "x" + std::to_string(input.height) + " pixels at (" + std::to_string(window.x) + ", " +
           std::to_string(window.y) + ") are no part of a picture of " + std::to_string(window.width) + "x" +
           std::to_string(window.height) + ", each side at most " + std::to_string(kMaxWholeSize));
  }
  check(input.camera);
  if (!std::isfinite(input.unit_distance) || input.unit_distance < 0) fail("unit distance must be a finite number, 0 or above");
  if (!finite(input.background)) fail("the background is not a colour");
  if (!input.mesh) fail("no mesh");
  if (input.styles.size() != input.mesh->summaries.size())
    fail(std::to_string(input.styles.size()) + " styles for " + std::to_string(input.mesh->summaries.size()) + " intervals");
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    const IntervalStyle& style = input.styles[i];
    const std::string which = "interval " + std::to_string(i) + ": ";
    if (!finite(style.color)) fail(which + "its colour is not a number");
    if (!(style.opacity >= 0 && style.opacity <= 1)) fail(which + "opacity must be in [0, 1]");
    if (style.opacity_upper && !(*style.opacity_upper >= 0 && *style.opacity_upper <= 1))
      fail(which + "the upper opacity must be in [0, 1]");
    if (style.constant()) continue;
    if (!style.color_map.empty()) color_map(style.color_map);  // throws where there is no such map
    if (!std::isfinite(style.color_lower) || !std::isfinite(style.color_upper))
      fail(which + "the range of colour and opacity is not finite");
    if (!input.color_values || input.color_values->size() != input.mesh->positions.size())
      fail(which + "a colour map or an upper opacity needs one value for each of the mesh's " +
           std::to_string(input.mesh->positions.size()) + " points");
  }
}

}  // namespace isostrata
