// The threads that make bytes of pictures, and the encoders of the video streams that live on them.
#pragma once

#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "encoding/encoder.h"
#include "engine/engine/lanes.h"
#include "engine/messages/messages.h"

namespace isostrata {

/// The encoders of one session's streams; only the session's jobs may call.
class StreamEncoders {
 public:
  /// Opens an encoder elsewhere, with a picture such as it will have, and calls opened with it.
  using Open = std::function<void(StreamId stream, Codec codec, Image first, EncodeOrder order)>;
  explicit StreamEncoders(Open open) : open_(std::move(open)) {}

  /// The stream's next frame, of which the first, and the first of another size, is a key frame. Nothing while an encoder of that size is being opened,
  /// which begins with the first call: the memory that it takes can cost the time of ten frames, and a hand would wait for it. A stream with a quantizer is a
  /// film's, for which nobody waits: its encoder is opened here. Throws what make_encoder and Encoder::encode throw.
  std::optional<EncodedFrame> encode(StreamId stream, Codec codec, const Image& image, EncodeOrder order);
  /// What open was asked for. failure: why there is none; else null. Nothing is kept for a stream that was closed meanwhile, or goes on in another size.
  struct Opened {
    StreamId stream = 0;
    int width = 0, height = 0;
    std::unique_ptr<Encoder> encoder;
    std::exception_ptr failure;
  };
  void opened(Opened opened);
  void close(StreamId stream) { streams_.erase(stream); }

 private:
  struct Stream {
    int width = 0, height = 0;
    std::unique_ptr<Encoder> encoder;  // null: it is being opened
    std::exception_ptr failure;
    bool begun = false;
  };
  const Open open_;
  std::map<StreamId, Stream> streams_;
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
  void open(SessionKey session, StreamId stream, Codec codec, const Image& first, const EncodeOrder& order);
  /// Of a session that is not closed.
  void post_to_known(SessionKey session, Job job);

  std::mutex mutex_;
  std::map<SessionKey, std::shared_ptr<StreamEncoders>> streams_;  // what they hold is touched by jobs alone
  Lanes lanes_;
  Lanes openers_;  // by session
};

}  // namespace isostrata
