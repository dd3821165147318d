// What an engine knows of one session: its newest scene, what has been extracted, and which of the waiting requests can be drawn of that.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "engine/engine/make_picture.h"
#include "engine/messages/messages.h"
#include "engine/messages/operation.h"
#include "engine/picture/extracted_scene.h"

namespace isostrata {

/// A picture that is being drawn or encoded.
struct Picture {
  std::shared_ptr<Task> task;
  std::uint64_t revision = 0;
  bool until_newer = false;  // a newer scene ends it
};

/// What has been extracted, and the scene that it is of.
struct Prepared {
  std::shared_ptr<const ExtractedScene> extracted;  // null: nothing
  Scene scene;
  bool drawn = false;  // its extraction time has been reported
};

/// Plain state; not thread-safe.
struct SessionState {
  std::optional<Scene> scene;  // the newest
  Prepared ready;              // of all points of the grid, or a first look at it
  Prepared coarse;             // of every n-th point, for moving frames that ask for it
  std::array<std::string, 2> coarse_arrays;  // that colours and textures could run over when it was made
  std::shared_ptr<Operation> extraction;     // running or queued
  Scene extraction_scene;
  bool extraction_is_coarse = false, last_was_cut_short = false;
  int asks_coarse = 0;                              // the last frame that was asked for: its level
  std::optional<RequestFailed> extraction_failure;  // of exactly the newest scene
  std::optional<Scene> drawn_meanwhile;             // the last picture of older intervals
  std::deque<FrameRequest> waiting;
  std::map<RequestId, Picture> pictures;
  bool frame_in_lane = false, still_in_lane = false;  // a job that draws one is posted or at work
  std::set<StreamId> streams;                         // ordered from and not closed

  /// What is ready for a scene of the same extraction, all points of the grid; else null.
  std::shared_ptr<const ExtractedScene> ready_for(const Scene& of) const;
  /// The same of every n-th point.
  std::shared_ptr<const ExtractedScene> coarse_for(const Scene& of) const;
  /// Of every n-th point of `of`. What is there of a newer scene stays: what was made in advance may come after what a hand has cut since.
  void take_coarse(std::shared_ptr<const ExtractedScene> extracted, const Scene& of);
  /// Whether nobody waits for more than every n-th point of the newest scene, which can be made of what is ready: the same grid and step.
  bool coarse_suffices() const;
  /// No scene is held any more.
  void give_back();

  /// Takes the first of the waiting requests that fit and can be drawn now, and counts it among the pictures. While the newest scene's intervals are being
  /// extracted that is an older scene from the newest camera, once for each view.
  std::optional<PictureOrder> next_order(const std::function<bool(const FrameRequest&)>& fits);

 private:
  std::optional<PictureOrder> order_of(const FrameRequest& request);
};

/// Whether all points of the grid went into it.
bool is_whole(const std::shared_ptr<const ExtractedScene>& extracted);
/// Arrays, besides the one that is cut, that the scene's colours and textures run over.
std::array<std::string, 2> color_arrays(const Scene& scene);

}  // namespace isostrata
