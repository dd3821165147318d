// The threads that make bytes of pictures, and the encoders of the video streams that live on them.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "encoding/encoder.h"
#include "engine/engine/lanes.h"
#include "engine/messages/messages.h"

namespace isostrata {

/// The encoders of one session's streams; only the session's jobs may call.
class StreamEncoders {
 public:
  /// Made when first asked for. Throws what make_encoder throws.
  Encoder& encoder(StreamId stream, Codec codec);
  void close(StreamId stream) { encoders_.erase(stream); }

 private:
  std::map<StreamId, std::unique_ptr<Encoder>> encoders_;
};

/// Each session has a lane, so that its frames leave in the order they were posted and wait for no other session's. Any thread may
/// call any function but the destructor, which drops the jobs that have not begun and waits for those that have. Jobs must not
/// throw. Lock: mutex_.
class EncoderThreads {
 public:
  using Job = std::function<void(StreamEncoders&)>;

  void post(SessionKey session, Job job);
  /// Takes effect after what was posted before.
  void close(SessionKey session, StreamId stream);
  /// The same; nothing may be posted for the session afterwards.
  void close_session(SessionKey session);

 private:
  std::mutex mutex_;
  std::map<SessionKey, std::shared_ptr<StreamEncoders>> streams_;  // what they hold is touched by jobs alone
  Lanes lanes_;
};

}  // namespace isostrata
