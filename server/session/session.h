// One session: a scene, the dataset it shows, and whoever looks at it. It outlives its connections.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "engine/messages.h"
#include "session/apply_command.h"
#include "session/viewer.h"

namespace isostrata {

/// How a session reaches the engine. Asked for something, the engine answers to the listener with that request's events, the last
/// of which is DatasetReady, HistogramReady, FrameReady or RequestFailed.
class EngineDoor {
 public:
  using Listener = std::function<void(const EngineEvent& event, TimePoint now)>;
  virtual ~EngineDoor() = default;
  virtual void post(EngineRequest request) = 0;
  /// Gives the request its number, posts it, and returns the number.
  virtual RequestId ask(EngineRequest request, Listener listener) = 0;
  /// The listener will not be called any more.
  virtual void forget(RequestId request) = 0;
};

/// Not thread-safe: lives on the io thread.
class Session {
 public:
  using Reply = std::function<void(std::optional<v1::Error> error)>;  // none: done

  Session(SessionKey key, EngineDoor& engine);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  SessionKey key() const { return key_; }
  const std::string& id() const { return id_; }
  const std::string& resume_token() const { return resume_token_; }
  const Scene& scene() const { return state_.scene; }
  const DatasetFacts* dataset() const { return dataset_.get(); }
  v1::State wire_state() const;
  bool watched() const { return !viewers_.empty(); }
  std::size_t viewer_count() const { return viewers_.size(); }
  TimePoint last_use() const { return last_use_; }
  void touch(TimePoint now) { last_use_ = now; }

  void attach(Viewer& viewer, TimePoint now);
  void detach(Viewer& viewer, TimePoint now);

  /// A message of a viewer that has said hello.
  void receive(Viewer& viewer, const v1::ClientMessage& message, TimePoint now);

  /// A scene command from anywhere; `viewer` is whose input it is, or null. While a dataset is being opened it waits its turn, so
  /// that commands take effect in the order they were given. expected: the revision that it is meant for; where the scene has
  /// another one when its turn comes, it is refused as "precondition_failed".
  void command(const v1::ClientMessage& message, Viewer* viewer, TimePoint now, Reply reply,
               std::optional<std::uint64_t> expected = {});
  /// Opens a dataset; another one that is still being opened is given up. What is open already stays as it is and is described
  /// again.
  void open(const std::string& id, Viewer* viewer, TimePoint now, Reply reply);
  /// The request that opens a dataset now; 0: none.
  RequestId opening() const { return opening_ ? opening_->request : 0; }
  /// Makes the scene what the state says, opening its dataset first where it is another one.
  void set_state(const v1::State& wanted, TimePoint now, Reply reply, std::optional<std::uint64_t> expected = {});

  /// One picture of the newest scene for a script. The answer is FrameReady or RequestFailed.
  RequestId picture(int width, int height, StillFormat format, EngineDoor::Listener listener, TimePoint now);

  /// An event of the session that answers no request: progress, done, a failed extraction.
  void on_event(const EngineEvent& event, TimePoint now);

  /// Asks for the frames that are due.
  void pump(TimePoint now);
  /// When pump may have something to do without an event.
  std::optional<TimePoint> wake_at(TimePoint now) const;

  void broadcast(const v1::ServerMessage& message);

 private:
  struct Opening {
    RequestId request = 0;
    std::string dataset;
    ViewerKey viewer = 0;
    std::uint64_t seq = 0;
    Reply reply;
  };

  Viewer* living(ViewerKey key);
  std::optional<v1::Error> unexpected(std::optional<std::uint64_t> expected) const;
  CommandContext context(const Viewer* viewer = nullptr) const { return {dataset_.get(), viewer ? viewer->frames.aspect() : 1}; }
  void changed(TimePoint now);
  void opened(const EngineEvent& event, TimePoint now);
  void run_deferred(TimePoint now);
  void pump(Viewer& viewer, TimePoint now);
  void play_cycle(TimePoint now);
  void on_frame_event(ViewerKey key, RequestId request, bool& had_started, const EngineEvent& event, TimePoint now);
  void send_histogram(Viewer& viewer, const v1::ClientMessage& message);

  const SessionKey key_;
  const std::string id_;
  const std::string resume_token_;
  EngineDoor& engine_;
  SceneState state_;
  std::shared_ptr<const DatasetFacts> dataset_;
  std::map<ViewerKey, Viewer*> viewers_;
  std::optional<Opening> opening_;
  std::deque<std::function<void(TimePoint)>> deferred_;  // commands that wait for opening_
  int histograms_ = 0;                                   // asked for and not answered
  TimePoint last_use_{};
  std::optional<TimePoint> next_phase_;  // when a cycle that plays shows its next interval
};

/// The error as it is sent.
v1::Error wire_error(const RequestFailed& failed);

}  // namespace isostrata
