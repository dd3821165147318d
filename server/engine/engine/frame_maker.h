// An order becomes a frame that is sent: drawn on the thread that brings a renderer, its bytes made on a thread of the session's.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "engine/engine/encoder_threads.h"
#include "engine/engine/make_picture.h"
#include "engine/messages/activity.h"
#include "engine/messages/frame_engine.h"
#include "engine/messages/messages.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// Every order is answered by FrameReady or RequestFailed. Any thread may call any function but the destructor, which drops the bytes that nobody has begun
/// to make, and waits for the others. Lock: mutex_, while nothing else is called.
class FrameMaker {
 public:
  /// Who knows the sessions. Called on any thread, without a lock.
  struct Ports {
    FrameEngine::Sink send;
    /// Memory for a large still, as long as it is held. Throws too_large.
    std::function<std::shared_ptr<void>(SessionKey session, std::uint64_t bytes, const std::string& what)> lend;
    /// Calls `then` if the session is there, while it cannot end. Returns whether.
    std::function<bool(SessionKey session, const std::function<void()>& then)> if_there;
    /// Whether the session has ended, or has a newer scene than this revision.
    std::function<bool(SessionKey session, std::uint64_t revision)> overtaken;
    /// The order has been answered.
    std::function<void(SessionKey session, RequestId request)> ended;
    /// A frame has been sent. A lossless one: the scene rests.
    std::function<void(SessionKey session, bool rests)> seen;
  };

  FrameMaker(ActivityBoard* board, Ports ports) : board_(board), ports_(std::move(ports)) {}

  /// What a device does for us has no pulse, so a frame gets time by its size, and more of a device that is software. Before the first order.
  void draw_on(const std::string& device);

  /// Who calls: the thread of a device, which is everybody's, so that turns are taken between pictures and the slices of large ones; or a lane of the
  /// session's, which may wait for its turn and end in the middle, and where a still is encoded, too.
  enum class On { render_thread, lane };
  /// instead: is added to the device's name. between: is called between two slices, if there is one; the order may end there, too. Returns why the device
  /// failed, if it did.
  std::optional<std::string> draw(Renderer& renderer, PictureOrder order, const std::string& instead, On thread, const std::function<void()>& between = {});
  /// Answers an order that cannot be drawn.
  void fail(const PictureOrder& order, const std::exception_ptr& why);

  /// Frames of this stream may be encoded until it is closed.
  void open_stream(SessionKey session, StreamId stream);
  void close_stream(SessionKey session, StreamId stream);
  /// Nothing is drawn for the session afterwards (if_there).
  void close_session(SessionKey session);

 private:
  void hand_to_encoder(DrawnPicture drawn, PictureOrder& order);
  void encode(StreamEncoders* streams, DrawnPicture& drawn, const PictureOrder& of);
  bool is_open(SessionKey session, StreamId stream);
  std::uint32_t patience_for(const FrameRequest& request) const;

  ActivityBoard* const board_;
  const Ports ports_;
  bool software_ = false;
  std::mutex mutex_;
  std::map<SessionKey, std::set<StreamId>> streams_;  // ordered from and not closed; guarded by mutex_
  EncoderThreads encoders_;
};

}  // namespace isostrata
