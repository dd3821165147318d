// Which pictures of a session are being made, and for whom. Whoever looks at the same size gets the same bytes, drawn and encoded once, also
// those whose credits come back a little later than the others'.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "session/pacing/video_streams.h"

namespace isostrata {

/// Pure bookkeeping: whoever calls asks the engine, and forgets what this says that nobody wants any more. Not thread-safe: lives on the io
/// thread.
class FramesInMaking {
 public:
  static constexpr int kMostMaking = 3;        // pictures: one that is drawn, one that is encoded, one that waits for that
  static constexpr std::size_t kMostKept = 4;  // pictures of the newest scene that are kept for whoever comes later

  /// One that is being made, for everyone who asked for the same one.
  struct Making {
    FrameRequest request;
    FrameOrder order;            // of whoever asked first
    std::uint64_t revision = 0;  // of the scene when it was asked for, or when its drawing began
    bool started = false;        // it is being drawn
    std::map<ViewerKey, FrameOrder> takers;
  };
  /// One of the newest scene that is there already, and the order as it meets it.
  struct Kept {
    FrameOrder order;
    FrameReady ready;
  };
  struct Joined {
    RequestId request = 0;
    bool started = false;
  };

  /// What would be drawn now would only wait for the encoder, and be older when it is sent than what is drawn later.
  bool crowded() const;
  /// One that is there and does for who ordered this.
  std::optional<Kept> kept_for(const FrameRequest& wanted, const FrameOrder& order, std::uint64_t revision) const;
  /// Takes part in one that is being made and does: one that is not being drawn yet, which will show the newest scene, or one that
  /// shows it. Never twice in the same one.
  std::optional<Joined> join(ViewerKey viewer, const FrameRequest& wanted, const FrameOrder& order, std::uint64_t revision);
  /// Is made for this viewer, and whoever joins.
  void ask(RequestId id, const FrameRequest& request, const FrameOrder& order, std::uint64_t revision, ViewerKey viewer);

  /// The viewer does not want that one. True: nobody does any more, and it is not made.
  bool leave(RequestId id, ViewerKey viewer);
  /// The viewer is gone. Those that nobody wants any more are not made, but for frames of a stream, every one of which has to come.
  std::vector<RequestId> leave_all(ViewerKey viewer);

  /// It is being drawn, of the scene of this revision. Null: it is none of these.
  const Making* start(RequestId id, std::uint64_t revision);
  /// It is ready, or has failed.
  std::optional<Making> finish(RequestId id);
  /// A picture that stands by itself and shows the newest scene is kept.
  void keep(const Making& made, const FrameReady& ready, std::uint64_t revision);
  /// The scene is another, or nobody is there: those that are kept are not looked at again.
  void forget_kept() { kept_.clear(); }

 private:
  struct Done {
    FrameRequest request;
    FrameOrder order;
    FrameReady ready;
  };

  std::map<RequestId, Making> making_;
  std::deque<Done> kept_;  // the newest first; none of an older scene
};

}  // namespace isostrata
