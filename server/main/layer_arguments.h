// Options that say what is extracted, shared by the commands that extract: combined ranges, time, triangulation.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "extraction/layers/extract_layers.h"
#include "scene/scene.h"

namespace isostrata {

struct LayerArguments {
  std::vector<SceneTerm> terms;  // in the order of the command line
  int step = 0;
  std::optional<double> time;
  std::string time_mode = "step";
  std::string triangulation = "table";
  FieldValues values = FieldValues::interpolated;
};

/// Adds --and, --or, --minus, --xor, --step, --time, --time-mode, --triangulation and --values. `arguments` must outlive the command.
void add_layer_options(CLI::App& command, LayerArguments& arguments);

/// A request without array and intervals.
LayerRequest layer_request(const LayerArguments& arguments);

/// Sets the scene's step, time, terms and triangulation.
void set_layers(Scene& scene, const LayerArguments& arguments);

/// The steps of FILE: the same one again while somebody holds it, or it is one of the last few that were opened.
StepSource step_source(const std::string& file);

/// "NAME=LOWER:UPPER[,color=#rrggbb|map:NAME][,opacity=X][,priority=N]", the parts after the range saying how what an OR or a XOR
/// brings in looks. Throws invalid_argument saying which part of which text.
SceneTerm parse_range_term(RangeOperator op, const std::string& text);

}  // namespace isostrata
