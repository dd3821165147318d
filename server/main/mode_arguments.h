// Options of the paper's modes: how the intervals share the picture, which steps are smeared, what textures run over, transfer
// functions.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/values/array.h"
#include "scene/scene.h"

namespace isostrata {

struct ModeArguments {
  std::string mode = "sorted", integral = "exact", texture, steps, times, transfer, color_range = "step";
  bool log_colors = false;
  std::vector<std::string> smear_colors;
  std::optional<double> phase;
  double seconds = 1;
};

/// Adds --mode, --integral, --texture, --transfer, --steps, --times, --smear-colors, --phase, --seconds, --color-range and --color-log. `arguments`
/// must outlive the command.
void add_mode_options(CLI::App& command, ModeArguments& arguments);

/// Sets the scene's mode, integral, texture, steps or times of a smear, phase and range of colours; and with --transfer its intervals, of the values of
/// `array`. Throws invalid_argument if options do not go together, and what read_transfer throws.
void set_modes(Scene& scene, const ModeArguments& arguments, const PointArray& array);

/// "0.5,1.25". Throws invalid_argument.
std::vector<double> parse_times(const std::string& text);

/// "0,2,5" or "FIRST:LAST" or "FIRST:LAST:STRIDE", the last included if it is met. Throws invalid_argument.
std::vector<int> parse_steps(const std::string& text);

/// The name of picture `index` of several: "%d" or "%03d" in it becomes the number; exactly one must stand there. Throws
/// invalid_argument.
std::string numbered_path(const std::string& path, std::size_t index);
bool is_numbered(const std::string& path);  // has a % in it

}  // namespace isostrata
