// How the scene of a session comes to show a dataset: for the first time, read again after its files have changed, awake after a restart of the
// server, or with the ranges of more steps.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/data/dataset_facts.h"
#include "scene/color_range.h"
#include "session/commands/apply_command.h"

namespace isostrata {

/// The range that colours run over: the scene's own, or that of its array's values as far as they are known. drawn: as drawn_scene made it;
/// facts: null if no dataset is open.
ColorRange known_color_range(const Scene& drawn, const DatasetFacts* facts);

/// Of one session. Pure: it changes the scene and says what came of it. Not thread-safe.
///
/// A scene that a journal has kept sleeps, as it was to the last byte, until its dataset is open: it can be judged only by its arrays.
class DatasetInScene {
 public:
  /// The state must outlive it.
  explicit DatasetInScene(SceneState& state) : state_(state) {}

  /// The scene as a journal has kept it. With a dataset it is asleep.
  void restore(const v1::State& kept, std::uint32_t last_interval_id);
  /// What sleeps; null: the scene is what it is.
  const v1::State* asleep() const { return asleep_ ? &*asleep_ : nullptr; }

  struct Shown {
    bool woken = false;              // it slept, and everyone has been told this state already
    bool changed = false;            // the scene is another one, of a new revision; else it is as it was
    std::optional<v1::Error> error;  // why it could not go on with the scene, and began anew
  };
  /// The dataset is open. reload: it was before, too, and the scene goes on with what is there now, as far as it fits. aspect: of the window of
  /// whoever asked. incomplete: ranges_read() will follow.
  Shown show(const DatasetFacts& facts, bool reload, double aspect, bool incomplete);
  /// The ranges of its arrays are complete; before: what was known, null if they stay that. True: the scene has a new revision.
  bool ranges_read(const DatasetFacts* before, const DatasetFacts& facts);

 private:
  Shown show_first(const DatasetFacts& facts, double aspect, bool incomplete);
  Shown show_again(const DatasetFacts& facts, double aspect);
  Shown wake(const DatasetFacts& facts);

  SceneState& state_;
  std::optional<Scene> first_look_;  // what a dataset was shown as, until its ranges are complete
  std::optional<v1::State> asleep_;
};

}  // namespace isostrata
