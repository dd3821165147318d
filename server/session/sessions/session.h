// One session: a scene, the dataset it shows, and whoever looks at it. It outlives its connections.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "session/commands/apply_command.h"
#include "session/datasets/dataset_in_scene.h"
#include "session/datasets/session_dataset.h"
#include "session/journal/journal.pb.h"
#include "session/pacing/cycle_clock.h"
#include "session/people/participants.h"
#include "session/people/resume_tokens.h"
#include "session/people/session_use.h"
#include "session/sessions/command_queue.h"
#include "session/sessions/shared_frames.h"
#include "session/sessions/viewer_answers.h"

namespace isostrata {

class Session;

/// Who keeps a session, and tells others of it. Calls come in the middle of what happens, and none may call the session back.
class SessionKeeper {
 public:
  virtual ~SessionKeeper() = default;
  /// Of all who may only look, in all sessions.
  virtual ViewerBudget& viewer_budget() = 0;
  /// What is to be kept of the session is another than before. now: it is on its way to the disk before anybody is told.
  virtual void session_changed(const Session&, bool now) = 0;
  /// The viewers have been told a new revision; other people are there, or may do other things.
  virtual void state_told(const Session&) = 0;
  virtual void people_changed(const Session&) = 0;
  /// Whoever came by the invitation is to be cut off.
  virtual void invitation_ended(const Session&, const std::string& invitation) = 0;
};

/// Not thread-safe: lives on the io thread.
class Session final : private SessionDataset::Audience {
 public:
  using Reply = Participants::Reply;

  Session(SessionKey key, EngineDoor& engine, SessionKeeper& keeper);
  /// One that a journal has kept. It sleeps, that is, its dataset is not opened, until somebody comes; its state is known at
  /// once.
  Session(SessionKey key, EngineDoor& engine, SessionKeeper& keeper, const journal::Entry& kept);
  ~Session() override;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  SessionKey key() const { return key_; }
  const std::string& id() const { return id_; }
  /// One that resumes it. Others that did before are good as well.
  const std::string& resume_token() const { return resume_.token(); }
  bool resume(const std::string& token) { return resume_.resume(token); }
  /// What a journal keeps of it.
  journal::Entry entry() const;
  const Scene& scene() const { return state_.scene; }
  /// The scene as the engine is told it.
  Scene drawn() const;
  v1::State wire_state() const;
  /// Of the dataset that is open; null: none is.
  const DatasetFacts* dataset() const { return dataset_.facts(); }
  /// The engine's id of its version; empty: none is.
  const std::string& shown() const { return dataset_.version(); }
  /// The request that opens a dataset now; 0: none.
  RequestId opening() const { return dataset_.opening_request(); }
  /// The request that reads all steps of the dataset for the ranges of its arrays; 0: none.
  RequestId reading_ranges() const { return dataset_.reading_ranges(); }

  Participants& people() { return people_; }
  const Participants& people() const { return people_; }
  bool watched() const { return !people_.empty(); }
  std::size_t viewer_count() const { return people_.size(); }
  const ClientCommands& commands() const { return commands_; }

  /// What is lost with it.
  SessionUse::Holds holds() const;
  TimePoint last_use() const { return use_.last(); }
  void touch(TimePoint now) {
    use_.touch(now);
    wake(now);
  }
  void touch_asleep(TimePoint now) { use_.touch(now); }
  /// Whether its dataset is being opened again after a restart; what is asked meanwhile would be told that there is none.
  bool waking() const { return scene_.asleep() && dataset_.opening(); }
  /// Calls back once it is awake, or has failed to wake.
  void after_waking(CommandQueue::Work then) { queue_.add(std::move(then)); }

  void attach(Viewer& viewer, TimePoint now);
  /// goodbye: it is done, and will not be back in a moment.
  void detach(Viewer& viewer, TimePoint now, bool goodbye);

  /// A message of a viewer that has said hello.
  void receive(Viewer& viewer, const v1::ClientMessage& message, TimePoint now);

  /// A scene command from anywhere; `viewer` is whose input it is, or null. While a dataset is being opened it waits its turn, so
  /// that commands take effect in the order they were given. expected: the revision that it is meant for; where the scene has
  /// another one when its turn comes, it is refused as "precondition_failed".
  void command(const v1::ClientMessage& message, Viewer* viewer, TimePoint now, Reply reply,
               std::optional<std::uint64_t> expected = {});
  /// Opens a dataset; another one that is still being opened is given up. What is open already stays as it is and is described
  /// again.
  void open(const std::string& id, Viewer* viewer, TimePoint now, Reply reply) {
    open_dataset(id, viewer, now, std::move(reply), false, 0);
  }
  /// The dataset, or the part of it, that the message asks for. command: the number that the viewer's client gave it.
  void open(const v1::OpenDataset& wanted, Viewer* viewer, TimePoint now, const Reply& reply, std::uint64_t command = 0);
  /// Reads the open dataset as it is on the disk now, if it has changed there; the scene goes on with it as far as it fits.
  void reload(Viewer* viewer, TimePoint now, Reply reply);
  /// The catalogue has changed.
  void look_at_files(TimePoint now) { dataset_.look_at_files(now); }
  /// A file that is waited for may not come.
  void look_at_waiting(TimePoint now) { dataset_.look_at_waiting(now); }
  /// Makes the scene what the state says, opening its dataset first if it is another one.
  void set_state(const v1::State& wanted, TimePoint now, Reply reply, std::optional<std::uint64_t> expected = {});

  /// One picture of the newest scene for a script. The answer is FrameReady or RequestFailed.
  RequestId picture(int width, int height, StillFormat format, bool transparent, EngineDoor::Listener listener, TimePoint now);

  /// What lies at a place of the newest picture of this size, for a script; a dataset must be open. The answer is ProbeReady or RequestFailed.
  RequestId probe(double x, double y, int width, int height, EngineDoor::Listener listener, TimePoint now);

  /// The values of an array along a line, or without `to` at a place over all steps, for a script; a dataset must be open. The answer is CurveReady or RequestFailed.
  RequestId curve(const std::string& array, Vec3d from, std::optional<Vec3d> to, EngineDoor::Listener listener, TimePoint now);

  /// One layer in numbers, for a script; a dataset must be open. The answer is LayerStatisticsReady or RequestFailed.
  RequestId layer_statistics(std::uint32_t interval, const std::string& array, EngineDoor::Listener listener, TimePoint now);

  /// An event of the session that answers no request: progress, done, a failed extraction.
  void on_event(const EngineEvent& event, TimePoint now);

  /// Asks for everyone's newest picture once more.
  void draw_again(TimePoint now);
  /// Asks for the frames that are due.
  void pump(TimePoint now);
  /// Has the engine let go what it extracted, if nobody has looked at it for a while.
  void let_rest(TimePoint now);
  /// When pump may have something to do without an event.
  std::optional<TimePoint> wake_at(TimePoint now) const;

 private:
  /// What viewers miss until work for this request (0: a scene's extraction) is done.
  v1::Purpose purpose_of(RequestId works_for) const;
  Session(SessionKey key, EngineDoor& engine, SessionKeeper& keeper, std::string id, ResumeTokens resume);

  CommandContext context(const Viewer* viewer = nullptr) const { return {dataset_.facts(), viewer ? viewer->frames.aspect() : 1}; }
  bool seen() const;
  bool drawable() const { return dataset_.facts() && !state_.scene.dataset.empty(); }

  /// What has changed the scene. Of cameras more may follow at once: engine, viewers and journal need not hear of each.
  enum class Cause { command, camera, clock };
  void changed(TimePoint now, Cause cause = Cause::command);
  void announce(TimePoint now);
  void play_cycle(TimePoint now);
  std::optional<v1::Error> unexpected(std::optional<std::uint64_t> expected) const;

  Reply reply_to(const Viewer& viewer, const v1::ClientMessage& message);
  void acknowledge(Viewer& viewer, std::uint64_t seq);
  void receive_ack(Viewer& viewer, const v1::FrameAck& ack, TimePoint now);
  void receive_still(Viewer& viewer, const v1::ClientMessage& message, TimePoint now, const Reply& reply);
  void receive_histogram(Viewer& viewer, const v1::ClientMessage& message);
  void receive_probe(Viewer& viewer, const v1::ClientMessage& message);
  void receive_curve(Viewer& viewer, const v1::ClientMessage& message);
  void receive_layer_statistics(Viewer& viewer, const v1::ClientMessage& message);

  void open_dataset(const std::string& id, Viewer* viewer, TimePoint now, Reply reply, bool reload, std::uint64_t command);
  void run_queue(TimePoint now);
  void wake(TimePoint now);

  void in_use(TimePoint now) override { use_.touch(now); }
  void tell(const v1::ServerMessage& message) override { people_.tell(message); }
  void show_dataset(const SessionDataset::Asker& asker, bool reload, TimePoint now) override;
  void opening_ended(TimePoint now) override { run_queue(now); }
  void ranges_read(std::shared_ptr<const DatasetFacts> before, TimePoint now) override;
  void steps_read(TimePoint now) override { pump(now); }
  void try_drawing_again(TimePoint now) override;

  const SessionKey key_;
  const std::string id_;
  EngineDoor& engine_;
  SessionKeeper& keeper_;
  ResumeTokens resume_;
  SessionUse use_;
  ClientCommands commands_;
  SceneState state_;
  DatasetInScene scene_;
  Participants people_;
  SessionDataset dataset_;
  SharedFrames frames_;
  ViewerAnswers answers_;
  CommandQueue queue_;  // waits for dataset_
  CycleClock cycle_;
  Scene told_;                // what the engine knows
  bool unannounced_ = false;  // the scene is newer than the engine and the viewers know
  TimePoint announced_{};
};

}  // namespace isostrata
