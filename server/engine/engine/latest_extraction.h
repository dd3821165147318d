// One session's newest scene: what has been extracted, what is being extracted, what has to be next, and what of it a picture shows meanwhile.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/messages/messages.h"
#include "engine/messages/operation.h"
#include "engine/picture/extracted_scene.h"

namespace isostrata {

/// What has been extracted, and the scene that it is of.
struct Prepared {
  std::shared_ptr<const ExtractedScene> extracted;  // null: nothing
  Scene scene;
  bool drawn = false;  // its extraction time has been reported
};

/// Plain state and its rules; not thread-safe. One extraction runs at a time, and what it was begun for may have been overtaken by a newer scene.
class LatestExtraction {
 public:
  using Extracted = std::shared_ptr<const ExtractedScene>;

  // ---- what is wanted ----

  /// The newest scene. The failure of an older one is forgotten, if this one would be extracted otherwise.
  void take(Scene scene);
  const std::optional<Scene>& scene() const { return scene_; }
  /// The level of the last frame that moves (FrameRequest::coarse).
  void ask_for(int level) { level_ = level; }
  int level() const { return level_; }

  /// Whether every n-th point of the newest scene will do, and can be made of what is ready: the same grid and step. all_coarse: nobody waits for more.
  bool coarse_suffices(bool all_coarse) const;

  enum class Next {
    nothing,
    extract,               // of all points
    extract_coarse,        // of every n-th
    overtake_at_once,      // what runs is for nobody any more
    overtake_after_grace,  // a newer scene has come: what runs is shown if it ends soon
  };
  /// What has to happen for the newest scene. Nothing is tried again after a failure until the scene changes.
  Next next(bool all_coarse) const;

  // ---- what runs ----

  /// Precondition: next() said so; operation is not null.
  void begin(std::shared_ptr<Operation> operation, bool coarse);
  const std::shared_ptr<Operation>& running() const { return running_; }
  /// What runs has ended. A failure that is that of the newest scene stays, with the scene's revision, and is returned: whoever waits is told. One of what
  /// was given up is wanted again by now, and null is returned as if there were none.
  const RequestFailed* end(const std::optional<RequestFailed>& failure);
  const std::optional<RequestFailed>& failure() const { return failure_; }
  /// What could not be read may be there now.
  void forget_failure() { failure_.reset(); }

  // ---- what there is ----

  const Prepared& ready() const { return ready_; }    // of all points of the grid, or a first look at it
  const Prepared& coarse() const { return coarse_; }  // of every n-th point, for moving frames that ask for it
  /// What is ready for a scene of the same extraction, all points of the grid; else null.
  Extracted ready_for(const Scene& of) const;
  /// The same of every n-th point.
  Extracted coarse_for(const Scene& of) const;

  /// All points of `of`.
  void take_ready(Extracted extracted, const Scene& of);
  /// Whether all points are there of a dataset and array of which they were not: a hand may take up at once what it has just been given. True once.
  bool take_news();
  /// Every n-th point of a scene of which there was nothing; all points follow.
  void take_first_look(Extracted extracted, const Scene& of);
  /// Of every n-th point of `of`. What is there of a newer scene stays: what was made in advance may come after what a hand has cut since.
  void take_coarse(Extracted extracted, const Scene& of);
  std::uint64_t bytes() const;
  /// No scene is held any more; for the caller to drop.
  std::array<Extracted, 2> give_back();

  // ---- what a picture shows ----

  struct Shown {
    Scene scene;
    Extracted extracted;
    double extract_ms = 0;  // to be reported with this picture
    bool coarse_at_hand = false, layers_may_be_coarse = false;
  };
  /// What the request's picture can be of now, which counts as shown. While the newest scene's intervals are being extracted that is an older scene from
  /// the newest camera, once for each view. Nothing: it has to wait.
  std::optional<Shown> show(const FrameRequest& request);

  /// For a picture that is not drawn after all.
  struct Mark {
    std::optional<Scene> drawn_meanwhile;
    bool ready_drawn = false;
  };
  Mark mark() const { return {drawn_meanwhile_, ready_.drawn}; }
  void undo_show(Mark before);

 private:
  bool is_of_other_data() const;

  std::optional<Scene> scene_;
  Prepared ready_, coarse_;
  bool news_ = false;
  std::array<std::string, 2> coarse_arrays_;  // that colours and textures could run over when it was made
  std::shared_ptr<Operation> running_;        // or queued
  Scene running_scene_;
  bool running_is_coarse_ = false, last_was_cut_short_ = false;
  int level_ = 0;
  std::optional<RequestFailed> failure_;  // of exactly the newest scene
  std::optional<Scene> drawn_meanwhile_;  // the last picture of older intervals
};

/// Whether all points of the grid went into it.
bool is_whole(const std::shared_ptr<const ExtractedScene>& extracted);

}  // namespace isostrata
