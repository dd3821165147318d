// One session: a scene, the dataset it shows, and whoever looks at it. It outlives its connections.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/messages/messages.h"
#include "session/commands/apply_command.h"
#include "session/journal/journal.pb.h"
#include "session/pacing/drawing_forecast.h"
#include "session/pacing/viewer.h"
#include "session/sessions/invitations.h"

namespace isostrata {

class Session;

/// How a session reaches the engine and its keepers. Asked for something, the engine answers to the listener with that request's
/// events, the last of which is DatasetReady, HistogramReady, FrameReady or RequestFailed.
class EngineDoor {
 public:
  using Listener = std::function<void(const EngineEvent& event, TimePoint now)>;
  virtual ~EngineDoor() = default;
  virtual void post(EngineRequest request) = 0;
  /// Gives the request its number, posts it, and returns the number.
  virtual RequestId ask(EngineRequest request, Listener listener) = 0;
  /// The listener will not be called any more.
  virtual void forget(RequestId request) = 0;
  /// What the catalogue says of a dataset now; null: nothing, or nothing follows the files.
  virtual const CatalogueEntry* entry(const std::string& /*dataset*/) const { return nullptr; }
  /// The id by which the engine knows the newest version of it (version_id).
  virtual std::string newest(const std::string& dataset) { return dataset; }
  /// Of all who may only look, in all sessions.
  virtual ViewerBudget& viewer_budget() = 0;
  /// What is to be kept of the session is another than before. now: it is on its way to the disk before anybody is told.
  virtual void session_changed(const Session&, [[maybe_unused]] bool now) {}
  /// The viewers have been told a new revision; other people are there, or may do other things.
  virtual void state_told(const Session&) {}
  virtual void people_changed(const Session&) {}
  /// Whoever came by the invitation is to be cut off. Not called back from within.
  virtual void invitation_ended(const Session&, const std::string&) {}
};

/// Not thread-safe: lives on the io thread.
class Session {
 public:
  using Reply = std::function<void(std::optional<v1::Error> error)>;  // none: done

  Session(SessionKey key, EngineDoor& engine);
  /// One that a journal has kept. It sleeps, that is, its dataset is not opened, until somebody comes; its state is known at
  /// once.
  Session(SessionKey key, EngineDoor& engine, const journal::Entry& kept);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  SessionKey key() const { return key_; }
  const std::string& id() const { return id_; }
  /// One that resumes it. Others that did before are good as well.
  const std::string& resume_token() const { return resume_token_; }
  /// Takes as long for every token. True: resume_token() is this one from now on.
  bool resume(const std::string& token);
  /// What a journal keeps of it.
  journal::Entry entry() const;
  const Scene& scene() const { return state_.scene; }
  const DatasetFacts* dataset() const { return dataset_.get(); }
  v1::State wire_state() const;
  bool watched() const { return !viewers_.empty(); }
  std::size_t viewer_count() const { return viewers_.size(); }
  /// What is lost with it: nothing, a first look that anyone can have again, what somebody has made of it.
  enum class Holds { nothing, look, work };
  /// Who vanished may come back so long.
  static constexpr Duration kComesBack = std::chrono::minutes(2);
  Holds holds() const;
  /// A viewer is gone: done with it, or vanished and perhaps back in a moment.
  void note_left(bool goodbye);
  TimePoint last_use() const { return last_use_; }
  void touch(TimePoint now) {
    last_use_ = now;
    wake(now);
  }
  void touch_asleep(TimePoint now) { last_use_ = now; }
  /// Whether its dataset is being opened again after a restart; what is asked meanwhile would be told that there is none.
  bool waking() const { return asleep_.has_value() && opening_.has_value(); }
  /// Calls back once it is awake, or has failed to wake.
  void after_waking(std::function<void(TimePoint)> then) { deferred_.push_back({std::move(then)}); }

  void attach(Viewer& viewer, TimePoint now);
  /// That its frames are made for. Who may only look gets pictures of at most kMaxViewerPixels, of the same shape.
  void set_viewport(Viewer& viewer, const v1::Viewport& viewport, TimePoint now);
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
  /// reload: also what is open already is read again where it has changed, and the scene goes on with it.
  void open(const std::string& id, Viewer* viewer, TimePoint now, Reply reply, bool reload = false);
  /// The dataset, or the part of it, that the message asks for.
  void open(const v1::OpenDataset& wanted, Viewer* viewer, TimePoint now, const Reply& reply);
  /// Reads the open dataset as it is on the disk now.
  void reload(Viewer* viewer, TimePoint now, Reply reply);
  /// The catalogue has changed.
  void on_disk(TimePoint now);
  /// A file that is waited for may not come.
  void look_at_waiting(TimePoint now);
  /// The engine's id of the version of the dataset that is shown; empty: none is.
  const std::string& shown() const { return shown_; }
  /// The request that opens a dataset now; 0: none.
  RequestId opening() const { return opening_ ? opening_->request : 0; }
  /// The request that reads all steps of the dataset for the ranges of its arrays; 0: none.
  RequestId reading_ranges() const { return reading_ranges_; }
  /// Makes the scene what the state says, opening its dataset first where it is another one.
  void set_state(const v1::State& wanted, TimePoint now, Reply reply, std::optional<std::uint64_t> expected = {});

  /// One picture of the newest scene for a script. The answer is FrameReady or RequestFailed.
  RequestId picture(int width, int height, StillFormat format, EngineDoor::Listener listener, TimePoint now);

  /// An event of the session that answers no request: progress, done, a failed extraction.
  void on_event(const EngineEvent& event, TimePoint now);

  /// Asks for everyone's newest picture once more.
  void draw_again(TimePoint now);
  /// Asks for the frames that are due.
  void pump(TimePoint now);
  /// When pump may have something to do without an event.
  std::optional<TimePoint> wake_at(TimePoint now) const;

  void broadcast(const v1::ServerMessage& message);

  // ---- people ----

  Invitations& invitations() { return invitations_; }
  const Invitations& invitations() const { return invitations_; }
  /// made_by: as Invitation's.
  Invitations::Made invite(const v1::CreateInvitation& wanted, const std::string& made_by = {});
  /// Cuts off whoever came by it. False where there is none of this id.
  bool revoke(const std::string& invitation);
  void expire_invitations(UnixMs now);
  v1::Invitation to_wire_invitation(const Invitation& invitation) const;
  v1::Participants participants() const;
  /// Tells everyone, once it has been welcomed.
  void came(const Viewer&) { people_changed(); }
  /// The newest command of this client that was judged; 0: none.
  std::uint64_t last_command(const std::string& client_id) const;
  /// What that one was refused with; null: it was done, or it is not known.
  const v1::Error* last_command_error(const std::string& client_id) const;

 private:
  /// A picture that is being made, for everyone who asked for the same one.
  struct Picture {
    FrameRequest request;
    FrameOrder order;            // of whoever asked first
    std::uint64_t revision = 0;  // of the scene when it was asked for: it shows this one or a newer one
    bool started = false;
    std::map<ViewerKey, FrameOrder> takers;
  };

  /// One of the newest scene that is there already.
  struct Made {
    FrameRequest request;
    FrameOrder order;
    FrameReady ready;
  };

  /// What the layers of a scene hold, for whoever sees them at rest.
  struct Measured {
    Scene scene;
    std::optional<v1::LayerFacts> facts;  // nothing: not known yet, or it failed
  };

  /// What moving frames cost here, ms: of drawing, and of encoding by weight().
  struct MakingCosts {
    DrawingForecast drawing, coarse_drawing;  // the latter of the first coarse level
    CodecCosts encoding{kUsualEncoding};
    double coarse_part = 0.4;  // of drawing, that drawing every n-th point takes
    bool coarse_at_hand = false;
    double extraction = 0, coarse_extraction = 0;  // ms, the last ones; likewise. 0: none yet
    bool extracts = false;                         // since the last rest: a hand moves layers, and does not only turn them
  };
  static constexpr double kUsualEncoding = 2.5;  // of video by that of JPEG

  struct Opening {
    RequestId request = 0;
    std::string dataset;
    ViewerKey viewer = 0;
    std::uint64_t seq = 0;
    double aspect = 1;  // of the viewer's window when the command came: pictures do not depend on how long opening takes
    Reply reply;
    std::string client;  // as in Deferred
    std::uint64_t command = 0;
    bool reload = false;
    std::string named;                     // the engine's id that was asked for
    CatalogueEntry asked;                  // as it was when it was asked for
    std::optional<RequestFailed> failure;  // it could not be read and is waited for
    TimePoint until{};                     // so long
    std::uint64_t waiting_as = 0;          // the operation by which viewers know that
    int tries = 0;
  };

  struct Deferred {
    std::function<void(TimePoint)> run;
    std::string client;         // whose command it is; empty: none that is numbered
    std::uint64_t command = 0;  // its number
  };

  struct Client {
    std::string id;
    std::uint64_t last_command = 0;
    bool guest = false;                   // an invitation's
    std::optional<v1::Error> error = {};  // of last_command
  };

  Viewer* living(ViewerKey key);
  std::optional<v1::Error> unexpected(std::optional<std::uint64_t> expected) const;
  CommandContext context(const Viewer* viewer = nullptr) const { return {dataset_.get(), viewer ? viewer->frames.aspect() : 1}; }
  /// What has changed the scene. Of cameras more may follow at once: engine, viewers and journal need not hear of each.
  enum class Cause { command, camera, clock };
  void changed(TimePoint now, Cause cause = Cause::command);
  void announce(TimePoint now);
  void opened(const EngineEvent& event, TimePoint now);
  bool try_again(const RequestFailed& failed, Opening& opening, TimePoint now);
  void wait_for_file(TimePoint now);
  void ask_again();
  void tell_waited(bool cancelled);
  void give_up_waiting(TimePoint now);
  void set_on_disk(OnDisk what);
  void read_new_steps(int parts);
  void show_reloaded(const Opening& opening, TimePoint now);
  void read_ranges();
  void ranges_read(const EngineEvent& event, TimePoint now);
  void give_up_ranges();
  void run_deferred(TimePoint now);
  void pump(Viewer& viewer, TimePoint now);
  bool crowded() const;
  void play_cycle(TimePoint now);
  void on_picture_event(RequestId request, const EngineEvent& event, TimePoint now);
  void give(Viewer& viewer, FrameOrder order, const FrameReady& ready, TimePoint now);
  void tell_layers(Viewer& viewer);
  void leave_picture(Viewer& viewer);
  void keepsake(Viewer& viewer, const v1::ClientMessage& message, TimePoint now);
  /// The scene as the engine is told it.
  Scene drawn() const;
  std::optional<v1::Error> refuse_still(Viewer& viewer, const v1::RequestStill& still, TimePoint now);
  void send_histogram(Viewer& viewer, const v1::ClientMessage& message);
  void begin_stream(Viewer& viewer, TimePoint now);
  void leave_stream(Viewer& viewer, TimePoint now);
  void end_streams();
  void step_down(Viewer& viewer, TimePoint now);
  /// Whether a viewer's moving frames may be of every n-th point.
  int coarse_level(const Viewer& viewer) const;
  /// Each way, of pictures at rest.
  int most_samples(const Viewer& viewer) const;
  void note_made(const Picture& picture, const FrameReady& ready, TimePoint now);
  void note_sent(Viewer& viewer, const FrameOrder& order, const FrameReady& ready, std::uint64_t frame);
  void note_decoded(Viewer& viewer, std::uint64_t frame, double ms, TimePoint now);
  void choose_codec(Viewer& viewer, TimePoint now);
  void use_codec(Viewer& viewer, TimePoint now);
  void send_bands(Viewer& viewer, TimePoint now);

  bool drawable() const { return dataset_ && !state_.scene.dataset.empty(); }
  void wake(TimePoint now);
  void woken(const DatasetFacts& facts, TimePoint now);

  /// Why the viewer may not; nothing where it may.
  std::optional<std::string> forbidden(const Viewer& viewer, const v1::ClientMessage& message) const;
  bool done_before(const Viewer& viewer, const v1::ClientMessage& message);
  void note_refused(const std::string& client_id, std::uint64_t command, const v1::Error& error);
  std::uint64_t settled_command(const Client& client) const;
  Viewer* back_again(const std::string& client_id);
  void people_changed();
  void set_role(Viewer& viewer, const v1::SetRole& wanted, const Reply& reply);
  bool answer_people(Viewer& viewer, const v1::ClientMessage& message, const Reply& reply);

  const SessionKey key_;
  const std::string id_;
  std::string resume_token_;
  std::vector<std::string> resume_hashes_;  // the one that was used last first
  EngineDoor& engine_;
  SceneState state_;
  std::shared_ptr<const DatasetFacts> dataset_;
  std::map<ViewerKey, Viewer*> viewers_;
  Scene told_;                // what the engine knows
  bool unannounced_ = false;  // the scene is newer than the engine and the viewers know
  TimePoint announced_{};
  std::optional<Opening> opening_;
  std::deque<Deferred> deferred_;    // commands that wait for opening_
  RequestId reading_ranges_ = 0;
  std::string shown_;            // as shown()
  int parts_ = 0;                // of it, that its times are known of
  RequestId reading_steps_ = 0;  // asks for the times of new ones
  bool unread_ = false;          // something of it could not be read
  std::optional<Scene> first_look_;  // what a dataset was shown as, until its ranges are complete
  std::optional<v1::State> asleep_;  // the state that a journal has kept, until its dataset is open
  std::map<RequestId, Picture> pictures_;
  std::deque<Made> made_;  // the newest first; none of an older scene
  std::optional<Measured> measured_;
  VideoStreams streams_;
  MakingCosts costs_;
  Invitations invitations_;
  std::deque<Client> clients_;  // the one that was heard last first
  int histograms_ = 0;          // asked for and not answered
  TimePoint last_use_{};
  bool worked_on_ = false;  // somebody has changed what a dataset shows at first
  bool left_ = false;       // nobody who may come back has left it
  bool vanished_ = false;   // somebody has, without a word, since somebody came
  std::optional<TimePoint> next_phase_;  // when a cycle that plays shows its next interval
};

/// The error as it is sent.
v1::Error wire_error(const RequestFailed& failed);

}  // namespace isostrata
