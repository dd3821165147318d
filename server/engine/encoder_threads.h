// The threads that make bytes of pictures, and the encoders of the video streams that live on them.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "encoding/encoder.h"
#include "engine/messages.h"
#include "engine/worker_threads.h"

namespace isostrata {

/// The encoders of the streams that one thread serves; only that thread may call.
class StreamEncoders {
 public:
  /// Made when first asked for. Throws what make_encoder throws.
  Encoder& encoder(SessionKey session, StreamId stream, Codec codec);
  void close(SessionKey session, StreamId stream) { encoders_.erase({session, stream}); }
  void close_session(SessionKey session);

 private:
  std::map<std::pair<SessionKey, StreamId>, std::unique_ptr<Encoder>> encoders_;
};

/// Each session is always on the same thread, so that its frames leave in the order they were posted. Any thread may call any
/// function but the destructor, which drops the jobs that have not begun and waits for those that have. Jobs must not throw.
class EncoderThreads {
 public:
  using Job = std::function<void(StreamEncoders&)>;

  explicit EncoderThreads(int threads = 2);
  void post(SessionKey session, Job job);
  /// Take effect after what was posted before.
  void close(SessionKey session, StreamId stream);
  void close_session(SessionKey session);

 private:
  struct Lane {
    StreamEncoders streams;  // touched by the thread's jobs alone
    WorkerThreads thread{1};
  };
  std::vector<std::unique_ptr<Lane>> lanes_;
};

}  // namespace isostrata
