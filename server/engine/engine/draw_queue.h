// One session's pictures: those that are waited for, which of them is drawn next, and those that are being drawn or encoded.
#pragma once

#include <algorithm>
#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "engine/engine/latest_extraction.h"
#include "engine/engine/make_picture.h"
#include "engine/messages/messages.h"

namespace isostrata {

/// Frames and stills are drawn beside each other, so a device apart each session has a lane of each.
enum class PictureKind { frame, still };
inline PictureKind kind_of(const FrameRequest& request) { return is_still(request) ? PictureKind::still : PictureKind::frame; }

/// Plain state and its rules; not thread-safe.
class DrawQueue {
 public:
  void push(FrameRequest request) { waiting_.push_back(std::move(request)); }
  /// Whether all that are waited for are of every n-th point, if there is one.
  bool all_coarse() const;
  bool empty() const { return waiting_.empty() && begun_.empty(); }

  /// Takes the first of those that are waited for that can be drawn now of what has been extracted, and counts it among those that are being drawn.
  /// kind: only one of these; nothing: any.
  std::optional<PictureOrder> next(LatestExtraction& of, std::optional<PictureKind> kind);
  /// It is drawn later, before all others.
  void put_back(const PictureOrder& order);
  /// It has been drawn and encoded, or has failed.
  void end(RequestId request) { begun_.erase(request); }

  /// Nobody waits for it any more: it does not begin, or is ended.
  void forget(RequestId request);
  /// Ends those that a scene of this revision, which is newer, makes useless.
  void cancel_older(std::uint64_t revision);
  void cancel_all();
  /// Nobody waits any more. Returns who did.
  std::deque<FrameRequest> refuse_waiting() { return std::exchange(waiting_, {}); }

  /// Whether one of the kind has to be drawn and none is: then the lane is taken, until it is free again.
  bool take_lane(PictureKind kind);
  void free_lane(PictureKind kind) { lane_taken(kind) = false; }

 private:
  /// That is being drawn or encoded.
  struct Begun {
    std::shared_ptr<Task> task;
    std::uint64_t revision = 0;
    bool until_newer = false;  // a newer scene ends it
  };
  bool& lane_taken(PictureKind kind) { return kind == PictureKind::still ? still_in_lane_ : frame_in_lane_; }

  std::deque<FrameRequest> waiting_;
  std::map<RequestId, Begun> begun_;
  std::shared_ptr<std::atomic<int>> legend_place_ = std::make_shared<std::atomic<int>>(-1);
  bool frame_in_lane_ = false, still_in_lane_ = false;
};

}  // namespace isostrata
