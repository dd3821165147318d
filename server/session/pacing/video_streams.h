// Who shares which video stream of a session. A frame of a stream is encoded once and must reach every member, in order; whoever
// misses one goes on with a stream of their own, so that nobody waits for the slowest; but a session has few streams, since each
// is an encoder that is paid for with every frame: beyond them the slow get pictures by themselves, which any two can share, for
// a while.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "engine/messages/messages.h"
#include "session/pacing/frame_scheduler.h"

namespace isostrata {

using ViewerKey = std::uint64_t;

/// Pure bookkeeping. Not thread-safe: lives on the io thread.
class VideoStreams {
 public:
  static constexpr Duration kFirstReturn = std::chrono::seconds(2);  // to a shared stream, after a frame was missed
  static constexpr Duration kLastReturn = std::chrono::seconds(64);  // doubled up to here each time

  static constexpr std::size_t kMostStreams = 3;
  static constexpr Duration kKeyPause = std::chrono::milliseconds(500);  // between key frames for the sake of those who join

  struct Choice {
    StreamId stream = 0;  // 0: none can be had now, a picture by itself has to do
    bool key = false;     // the frame must be a key frame: the viewer has none of the ones before
  };

  /// Whether choose() would give one, as far as can be known without the size.
  bool has_room(ViewerKey viewer, TimePoint now) const;
  /// The stream of the viewer's next frame of this codec and size: the one they have, else one that others have, else a new one.
  Choice choose(ViewerKey viewer, Codec codec, int width, int height, TimePoint now);
  /// Goes on with a stream of their own, and comes back to others' later.
  void missed(ViewerKey viewer, TimePoint now);
  /// Has no stream any more; of a viewer that is gone everything is forgotten.
  void leave(ViewerKey viewer, bool gone = false);

  /// The members that a frame of this stream is for, given whether it is a key frame; those who wait for one get no other.
  std::vector<ViewerKey> takers(StreamId stream, bool key, TimePoint now);
  std::vector<ViewerKey> members(StreamId stream) const;
  /// 0: none yet.
  StreamId of(ViewerKey viewer) const;
  /// Streams that nobody has any more, each told once.
  std::vector<StreamId> take_ended() { return std::exchange(ended_, {}); }

 private:
  struct Stream {
    Codec codec = Codec::vp9_444;
    int width = 0, height = 0;
    std::map<ViewerKey, bool> members;  // whether they have had a key frame of it
    std::optional<TimePoint> key_at;    // of the last one
  };
  struct Past {
    TimePoint back_at{};
    Duration next_pause = kFirstReturn;
  };

  bool sociable(ViewerKey viewer, TimePoint now) const;

  std::map<StreamId, Stream> streams_;
  std::map<ViewerKey, Past> past_;  // of those who have missed a frame
  std::vector<StreamId> ended_;
  StreamId last_ = 0;
};

}  // namespace isostrata
