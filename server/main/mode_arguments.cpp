#include "main/mode_arguments.h"

#include <charconv>
#include <cmath>

#include "base/error.h"
#include "main/transfer_file.h"

namespace isostrata {
namespace {

constexpr std::size_t kMaxSmearSteps = 1024;

SceneMode mode_of(const std::string& text) {
  return text == "prioritized" ? SceneMode::prioritized
         : text == "cycled"    ? SceneMode::cycled
         : text == "smear"     ? SceneMode::smear
                               : SceneMode::sorted;
}

[[noreturn]] void refuse(const std::string& why) { throw Error(ErrorCode::invalid_argument, why); }

}  // namespace

void add_mode_options(CLI::App& command, ModeArguments& arguments) {
  command
      .add_option("--mode", arguments.mode,
                  "sorted: back to front; prioritized: higher priorities are painted over lower ones; cycled: one interval at a "
                  "time; smear: several time steps (--steps) or times (--times) over one another, each in a colour of its own")
      ->check(CLI::IsMember({"sorted", "prioritized", "cycled", "smear"}))
      ->capture_default_str();
  command
      .add_option("--integral", arguments.integral,
                  "Light through a tetrahedron. exact: to half an 8-bit step; table2d: by a table over length and mean value, as "
                  "published")
      ->check(CLI::IsMember({"exact", "table2d"}))
      ->capture_default_str();
  command.add_option("--texture", arguments.texture,
                     "The array that surfaces' textures run over, over its whole range (default: --color-by, else --array)");
  command.add_option("--transfer", arguments.transfer,
                     "A transfer function in place of --interval: FILE.json with \"points\" of value, color and opacity, or a "
                     "table of R G B [OPACITY] over the array's range");
  command.add_option("--steps", arguments.steps,
                     "Steps, 0,2,5 or FIRST:LAST[:STRIDE]: a picture of each, all from one camera; frame-%04d.png numbers them by their steps, film.webm or film.png holds them all. With "
                     "--mode smear the steps of one picture in the order they are painted");
  command.add_option("--times", arguments.times,
                     "With --mode smear, in place of --steps: times in the order they are painted, 0.5,1.25, also between steps; "
                     "--time-mode says what is shown there");
  command.add_option("--smear-colors", arguments.smear_colors, "With --mode smear: #rrggbb of each step or time")->delimiter(',');
  command.add_option_function<double>(
      "--phase", [&arguments](const double& phase) { arguments.phase = phase; },
      "With --mode cycled: draw this interval alone, counted from 0 (default: all, as frame-%02d.png or an animated .png)");
  command
      .add_option("--seconds", arguments.seconds, "Of a film or an animated picture: how long each interval, or step, is shown")
      ->check(CLI::Range(0.01, 600.0))
      ->capture_default_str();
  command
      .add_option("--color-range", arguments.color_range,
                  "The values of --color-by at which colour maps, and opacity that runs, begin and end: step (its range at the "
                  "step that is shown), all-steps, or LOWER:UPPER")
      ->capture_default_str();
  command.add_flag("--color-log", arguments.log_colors,
                   "Colours run with the value's logarithm; a range that reaches 0 or below begins at a ten-thousandth of its "
                   "upper end");
}

void set_modes(Scene& scene, const ModeArguments& arguments, const PointArray& array) {
  scene.mode = mode_of(arguments.mode);
  scene.integral = arguments.integral == "table2d" ? Integral::table2d : Integral::exact;
  scene.texture = arguments.texture;
  if (!arguments.transfer.empty()) {
    if (!scene.color_by.empty() && scene.color_by != array.name)
      refuse("--transfer gives colours by the values of '" + array.name + "'; --color-by '" + scene.color_by +
             "' does not go with it");
    scene.intervals = transfer_intervals(read_transfer(arguments.transfer, array.lower, array.upper));
  }
  if (scene.mode != SceneMode::smear && (!arguments.times.empty() || !arguments.smear_colors.empty())) refuse("--times and --smear-colors go with --mode smear");
  if (scene.mode == SceneMode::cycled && !arguments.steps.empty()) refuse("--steps and --mode cycled are several pictures each; expected one of them");
  if (scene.mode != SceneMode::cycled && arguments.phase) refuse("--phase goes with --mode cycled");
  if (scene.mode == SceneMode::smear) {
    if (arguments.steps.empty() == arguments.times.empty()) refuse("--mode smear needs --steps or --times, one of them");
    if (scene.time) refuse("--mode smear shows --steps or --times; --time does not go with it");
    if (arguments.times.empty())
      scene.smear.steps = parse_steps(arguments.steps);
    else
      scene.smear.times = parse_times(arguments.times);
    for (const std::string& color : arguments.smear_colors) scene.smear.colors.push_back(parse_rgb(color));
  }
  scene.color_range.log = arguments.log_colors;
  if (arguments.color_range == "all-steps") {
    scene.color_range.span = ColorSpan::all_steps;
  } else if (arguments.color_range != "step") {
    const auto colon = arguments.color_range.find(':', 1);
    ColorRange& range = scene.color_range;
    range.span = ColorSpan::own;
    const auto number = [](std::string_view text, double& value) {
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      return error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
    };
    const std::string_view text = arguments.color_range;
    if (colon == std::string::npos || !number(text.substr(0, colon), range.lower) || !number(text.substr(colon + 1), range.upper) ||
        !(range.lower < range.upper))
      refuse("--color-range '" + arguments.color_range + "': expected step, all-steps or LOWER:UPPER");
    if (range.log && !(range.lower > 0))
      refuse("--color-range '" + arguments.color_range + "': with --color-log LOWER must be above 0");
  }
  scene.cycle.seconds = arguments.seconds;
  if (arguments.phase) {
    if (!(*arguments.phase >= 0 && *arguments.phase < static_cast<double>(scene.intervals.size() + scene.terms.size())))
      refuse("--phase " + std::to_string(*arguments.phase) + " is not there; expected 0 to less than the number of intervals, " +
             std::to_string(scene.intervals.size()));
    scene.cycle.phase = *arguments.phase;
  }
}

std::vector<int> parse_steps(const std::string& text) {
  const auto wrong = [&text]() { refuse("steps '" + text + "': expected 0,2,5 or FIRST:LAST[:STRIDE]"); };
  std::vector<int> numbers;
  const char separator = text.find(':') != std::string::npos ? ':' : ',';
  for (std::string_view rest = text;;) {
    const auto part = rest.substr(0, rest.find(separator));
    int value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc{} || end != part.data() + part.size() || value < 0) wrong();
    numbers.push_back(value);
    if (part.size() == rest.size()) break;
    rest.remove_prefix(part.size() + 1);
  }
  if (separator == ':') {
    if (numbers.size() > 3 || (numbers.size() == 3 && numbers[2] == 0)) wrong();
    const int first = numbers[0], last = numbers[1], stride = numbers.size() == 3 ? numbers[2] : 1;
    numbers.clear();
    const bool up = first <= last;
    for (std::int64_t step = first; up ? step <= last : step >= last; step += up ? stride : -stride) {
      if (numbers.size() > kMaxSmearSteps) break;
      numbers.push_back(static_cast<int>(step));
    }
  }
  if (numbers.size() > kMaxSmearSteps) refuse("steps '" + text + "': more than " + std::to_string(kMaxSmearSteps) + " of them");
  return numbers;
}

std::vector<double> parse_times(const std::string& text) {
  std::vector<double> times;
  for (std::string_view rest = text;;) {
    const auto part = rest.substr(0, rest.find(','));
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc{} || end != part.data() + part.size() || !std::isfinite(value))
      refuse("times '" + text + "': expected numbers such as 0.5,1.25");
    times.push_back(value);
    if (part.size() == rest.size()) break;
    rest.remove_prefix(part.size() + 1);
  }
  if (times.size() > kMaxSmearSteps) refuse("times '" + text + "': more than " + std::to_string(kMaxSmearSteps) + " of them");
  return times;
}

bool is_numbered(const std::string& path) { return path.find('%') != std::string::npos; }

std::string numbered_path(const std::string& path, std::size_t index) {
  const auto wrong = [&path]() { refuse("'" + path + "': expected one %d, or %03d with the number of digits, in the name"); };
  const auto at = path.find('%');
  if (at == std::string::npos || path.find('%', at + 1) != std::string::npos) wrong();
  auto end = at + 1;
  const bool zeros = end < path.size() && path[end] == '0';
  std::size_t width = 0;
  for (; end < path.size() && path[end] >= '0' && path[end] <= '9' && width < 10; ++end)
    width = 10 * width + static_cast<std::size_t>(path[end] - '0');
  if (end >= path.size() || path[end] != 'd' || width > 9 || (width > 0 && !zeros)) wrong();
  std::string number = std::to_string(index);
  if (number.size() < width) number.insert(0, width - number.size(), '0');
  return path.substr(0, at) + number + path.substr(end + 1);
}

}  // namespace isostrata
