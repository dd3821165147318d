#include "main/picture_arguments.h"

#include <charconv>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr int kMaxSize = 16384;
constexpr int kDefaultIntervals = 4;

SceneInterval scene_interval(const IntervalArgument& argument, std::size_t index) {
  SceneInterval interval;
  interval.id = static_cast<std::uint32_t>(index + 1);
  interval.lower = argument.interval.lower;
  interval.upper = argument.interval.upper;
  interval.color = argument.style.color;
  interval.color_map = argument.style.color_map;
  interval.opacity = argument.style.opacity;
  interval.opacity_upper = argument.style.opacity_upper;
  interval.priority = argument.style.priority;
  interval.name = argument.name;
  interval.surface = argument.style.surface;
  return interval;
}

}  // namespace

std::array<int, 2> parse_size(std::string_view text, std::string_view what) {
  std::array<int, 2> size{};
  const auto cross = text.find('x');
  const auto parse = [](std::string_view part, int& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size() && value >= 1 && value <= kMaxSize;
  };
  if (cross == std::string_view::npos || !parse(text.substr(0, cross), size[0]) || !parse(text.substr(cross + 1), size[1]))
    throw Error(ErrorCode::invalid_argument,
                std::string(what) + " '" + std::string(text) + "': expected WIDTHxHEIGHT, each from 1 to " + std::to_string(kMaxSize));
  return size;
}

std::vector<SceneInterval> parse_intervals(const std::vector<std::string>& texts, const Dataset& dataset,
                                           const PointArray& array) {
  std::vector<SceneInterval> intervals;
  for (std::size_t i = 0; i < texts.size(); ++i) intervals.push_back(scene_interval(parse_interval(texts[i], i), i));
  if (!intervals.empty()) return intervals;
  if (!(array.lower < array.upper))
    throw Error(ErrorCode::not_found,
                dataset.name + ": array '" + array.name + "' has no range of values to divide; give --interval");
  const double step = (array.upper - array.lower) / kDefaultIntervals;
  for (int i = 0; i < kDefaultIntervals; ++i) {
    IntervalArgument argument;
    argument.interval = {array.lower + step * i, i + 1 < kDefaultIntervals ? array.lower + step * (i + 1) : array.upper};
    argument.style.color = default_interval_color(static_cast<std::size_t>(i));
    argument.style.opacity = 0.3;
    intervals.push_back(scene_interval(argument, static_cast<std::size_t>(i)));
  }
  return intervals;
}

}  // namespace isostrata
