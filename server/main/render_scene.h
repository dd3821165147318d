// The scene that `isostrata render` draws: of its options alone, or of a session's state and the options that override it.
#pragma once

#include <CLI/CLI.hpp>

#include "engine/picture/extract_scene.h"
#include "main/render_arguments.h"
#include "scene/scene.h"

namespace isostrata {

/// aspect: width over height. dataset: of a step that was read. Throws what the parsers of the options throw.
Scene wanted_scene(const RenderArguments& arguments, const CLI::App& command, const StepSource& steps, const Dataset& dataset, double aspect);

/// The scene as it is drawn. For colours over all steps each of them is read.
Scene scene_as_drawn(const Scene& wanted, const StepSource& steps, const Dataset& dataset);

}  // namespace isostrata
