// One connection of a session: where its messages go, and its frames.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/messages/messages.h"
#include "isostrata/v1/isostrata.pb.h"
#include "session/pacing/frame_scheduler.h"
#include "session/pacing/moving_format.h"
#include "session/pacing/video_streams.h"
#include "session/pacing/viewer_budget.h"
#include "session/people/observed_acts.h"

namespace isostrata {

/// The way to one client. net's connections are outboxes; so are the fakes of tests. Calls never wait and never call back.
class Outbox {
 public:
  virtual ~Outbox() = default;
  /// Sends messages in order, before any frame that waits.
  virtual void send(v1::ServerMessage message) = 0;
  /// As send, but a State that still waits is replaced: the newest wins.
  /// heeded: as ServerMessage says it.
  virtual void send_state(v1::State state, std::uint64_t heeded) = 0;
  /// The frame's payload is apart, since viewers of one picture share its bytes; `frame` has none.
  virtual void send_frame(v1::Frame frame, std::shared_ptr<const Bytes> payload) = 0;
  /// Sends what waits, then closes. `code` is a WebSocket close code.
  virtual void close(std::uint16_t code, const std::string& reason) = 0;
};

/// Not thread-safe: lives on the io thread.
struct Viewer {
  struct Band {
    v1::Frame frame;
    std::shared_ptr<const Bytes> payload;
  };

  ViewerKey key = 0;
  Outbox* outbox = nullptr;
  SessionKey session = 0;  // 0: has not said hello
  std::uint64_t last_seq = 0;
  std::uint64_t heeded = 0;  // of its commands, the newest that was judged
  std::uint64_t ignored_messages = 0;
  FrameScheduler frames;
  MovingFormat format;
  bool takes_bands = false;       // lossless pictures in pieces
  bool refines = false;           // wants pictures of more samples after them
  std::deque<Band> bands;         // of the newest one, that have not been sent
  bool awaits_layers = false;     // and what its layers hold has not been told
  StreamId stream = 0;            // of its moving frames, if that is video and one has been ordered
  RequestId ordered_request = 0;  // not started

  v1::Viewport viewport;                   // as it was asked for
  TokenBucket stills{kViewerStillsPerSecond, kViewerStillsAtOnce};  // that it may ask for where it may only look
  std::int64_t server_pixels = kMaxViewerPixels;  // of its pictures, there: as many as the server allows
  std::int64_t session_pixels = 0;                // and as a controller of the session does; 0: no fewer
  TimePoint pays_at{};  // the next picture for it alone waits until then

  v1::Role role = v1::ROLE_CONTROLLER;
  std::string invitation;  // that it came by; empty: it has the server's token
  std::string name, client, client_id;
  std::string address;     // at the other end of its connection, if that is known
  ObservedActs acts;

  /// That its frames are made for. Who may only look gets pictures of at most most_pixels(), of the same shape.
  void set_viewport(const v1::Viewport& wanted, TimePoint now);
  /// Why it may not have this still; else one is taken from what it may ask for.
  std::optional<v1::Error> refuse_still(const v1::RequestStill& still, TimePoint now);

  std::int64_t most_pixels() const { return session_pixels > 0 ? std::min(server_pixels, session_pixels) : server_pixels; }

  /// The message `seq` is contained in `revision` and all later ones.
  void note_input(std::uint64_t seq, std::uint64_t revision);
  /// The newest message that a picture of `revision` contains.
  std::uint64_t input_of(std::uint64_t revision);

 private:
  struct Input {
    std::uint64_t revision;
    std::uint64_t seq;
  };
  std::deque<Input> inputs_;         // both increase
  std::uint64_t contained_seq_ = 0;  // of the newest revision that was asked for
};

}  // namespace isostrata
