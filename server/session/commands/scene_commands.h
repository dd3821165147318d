// What each command does to a scene, or why it does not (command_checks.h). apply_command hands a copy in, so a refusal in the middle
// leaves nothing behind.
#pragma once

#include "session/commands/apply_command.h"

namespace isostrata {

// data_commands.cpp: what is looked at
void apply(SceneState& state, const v1::SelectArrays& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetTimeStep& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetTime& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetCombination& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetCycle& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetSmear& command, const CommandContext& context);

// layer_commands.cpp: the intervals and their looks
void apply(SceneState& state, const v1::SetTransferFunction& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetIntervals& command, const CommandContext& context);
void apply(SceneState& state, const v1::PatchInterval& command, const CommandContext& context);
void apply(SceneState& state, const v1::RemoveInterval& command, const CommandContext& context);
void apply(SceneState& state, const v1::ReorderPriorities& command, const CommandContext& context);
bool has_transfer(const Scene& scene);                                      // of any interval
void move_ends(SceneInterval& interval, double lower, double upper);        // its transfer function goes along

// view_commands.cpp: from where, and in which light
void set_axis_scale(Scene& scene, Vec3d axis_scale, const CommandContext& context);  // the camera goes along
void apply(SceneState& state, const v1::SetCamera& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetView& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetClipPlanes& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetAnnotations& command, const CommandContext& context);
void apply(SceneState& state, const v1::SetAppearance& command, const CommandContext& context);

}  // namespace isostrata
