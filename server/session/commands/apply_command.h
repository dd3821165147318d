// The one place where Protobuf meets our types: every field that came from outside is checked here before anything else sees it.
#pragma once

#include <optional>
#include <string>

#include "engine/data/dataset_facts.h"
#include "isostrata/v1/isostrata.pb.h"
#include "scene/scene.h"

namespace isostrata {

/// What commands are judged against.
struct CommandContext {
  const DatasetFacts* dataset = nullptr;  // of scene.dataset; null if none is open
  double aspect = 1;                      // of the asker's viewport: a view shows the whole dataset in it
};

/// What a command did. With an error (code, message, field; in_reply_to is the caller's) the scene is as it was.
struct CommandOutcome {
  std::optional<v1::Error> error;
  bool changed = false;  // the scene has a new revision
};

/// Interval ids are never used again in one session.
struct SceneState {
  Scene scene;
  std::uint32_t last_interval_id = 0;
};

/// Whether the message is one that apply_command takes.
bool is_scene_command(const v1::ClientMessage& message);

/// Does the command to the scene, or to nothing at all. A command that changes nothing does not make a revision.
CommandOutcome apply_command(SceneState& state, const v1::ClientMessage& message, const CommandContext& context);

/// Makes the scene what `wanted` says, as one change: array, colour array, step or time, terms, intervals, mode,
/// camera, background and unit distance; its dataset must be the open one, its revision is ignored. Empty and absent fields
/// stay as they are, except that the lists of intervals and terms are always taken, and that no time means the step.
CommandOutcome apply_state(SceneState& state, const v1::State& wanted, const CommandContext& context);

/// The scene that a journal has kept, as it was to the last id, judged by the dataset's arrays; the revision is the saved one.
std::optional<v1::Error> restore_state(SceneState& state, const v1::State& saved, std::uint32_t last_interval_id,
                                       const CommandContext& context);

/// Shows the interval that comes `steps` after the one that a cycle shows. False if nothing changes: another mode, fewer than
/// two that could be shown.
bool advance_cycle(SceneState& state, std::int64_t steps);

/// Where one stands when the dataset has just been opened, and after *Reset*: all that its first_view shows is in the picture, or the
/// whole box if it has none. The same for every picture at least as wide as high; from a narrower one, `aspect` times as wide as high,
/// it is farther away.
Camera opening_camera(const DatasetFacts& dataset, double aspect);

/// A first look at a dataset that was just opened: its first_view from its opening_camera; if it has none, its first array without
/// layers. Appearance stays as it is, but for a smear of a dataset of one step.
void open_in_scene(SceneState& state, const DatasetFacts& dataset, double aspect = 1);
/// The array and the layers of a first look at the dataset, in place of those that are there; they keep their ids. False where
/// they are the same.
bool show_first_layers(SceneState& state, const DatasetFacts& dataset);

/// The id of what is to be opened: of the part, if the message asks for one. Sets the error, naming the field, if that cannot be read.
std::string asked_dataset(const v1::OpenDataset& wanted, std::optional<v1::Error>& error);

/// Null if the size is one that can be drawn; names the field that is not.
std::optional<v1::Error> check_size(std::uint32_t width, std::uint32_t height);
/// Null if the place is one of a picture.
std::optional<v1::Error> check_probe(const v1::ProbePoint& probe);
/// Null if the points are there and finite, two of a line and not the same, and the open dataset has the array; of a place over steps, if it has several.
std::optional<v1::Error> check_line(const v1::ProbeLine& line, const CommandContext& context);
std::optional<v1::Error> check_steps(const v1::ProbeSteps& probe, const CommandContext& context);
/// Null if the scene has the interval, and the open dataset the array.
std::optional<v1::Error> check_layer(std::uint32_t interval, const std::string& array, const Scene& scene, const CommandContext& context);
std::optional<v1::Error> check_histogram(const v1::RequestHistogram& request, const CommandContext& context);

}  // namespace isostrata
