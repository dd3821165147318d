// The dataset of a session: how it is opened, and what becomes of its files while it is open.
//
// A series that grows gains its steps by itself: nothing that is shown changes. A file that was rewritten is shown again when somebody asks
// for it (ReloadDataset), as in ParaView (Reload Files) and VisIt (ReOpen): a picture that people look at, talk about and measure in does not
// change under their hands, and steps of an old and a new run are never mixed in one animation. A deleted file is shown from memory. A file
// that is being written when it is asked for is waited for.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "session/datasets/engine_door.h"
#include "session/pacing/video_streams.h"
#include "session/people/client_commands.h"

namespace isostrata {

/// Of one session. Not thread-safe: lives on the io thread; the clock is passed in.
class SessionDataset {
 public:
  using Reply = std::function<void(std::optional<v1::Error> error)>;  // none: done

  /// Whose input it was that a dataset is opened.
  struct Asker {
    ViewerKey viewer = 0;
    std::uint64_t seq = 0;
    double aspect = 1;  // of the viewer's window when the command came: pictures do not depend on how long opening takes
    CommandNumber command;
  };

  /// Whoever shows it. Calls come from within those of this object, when it may be asked and told anything again.
  class Audience {
   public:
    virtual ~Audience() = default;
    /// The engine has answered: somebody uses the session.
    virtual void in_use(TimePoint now) = 0;
    /// A message for everyone.
    virtual void tell(const v1::ServerMessage& message) = 0;
    /// facts() are of the dataset that was asked for. reload: it was open, and has been read again.
    virtual void show_dataset(const Asker& asker, bool reload, TimePoint now) = 0;
    /// Nothing is being opened now: what waited for it may go on.
    virtual void opening_ended(TimePoint now) = 0;
    /// All steps have been read for the ranges of the arrays; before: facts() until then, null if that was ended or failed.
    virtual void ranges_read(std::shared_ptr<const DatasetFacts> before, TimePoint now) = 0;
    /// facts() have more steps.
    virtual void steps_read(TimePoint now) = 0;
    /// What could not be read may be there now.
    virtual void try_drawing_again(TimePoint now) = 0;
  };

  /// Both must outlive it.
  SessionDataset(SessionKey session, EngineDoor& engine, Audience& audience) : session_(session), engine_(engine), audience_(audience) {}
  /// Ends waiting for a dataset that is being opened; whoever does is not told.
  ~SessionDataset();
  SessionDataset(const SessionDataset&) = delete;
  SessionDataset& operator=(const SessionDataset&) = delete;

  /// Of the one that is open; null: none is.
  const DatasetFacts* facts() const { return facts_.get(); }
  /// The engine's id of its version; empty: none is.
  const std::string& version() const { return version_; }
  /// Whether there is nothing to do to have it open, or open as it is on the disk.
  bool is_open(const std::string& id, bool reload);
  bool opening() const { return opening_.has_value(); }
  /// That opens a dataset now; 0: none, or its file is waited for.
  RequestId opening_request() const { return opening_ ? opening_->request : 0; }
  /// The command by which one is being opened.
  CommandNumber opening_command() const { return opening_ ? opening_->asker.command : CommandNumber{}; }
  /// That reads all steps for the ranges of the arrays; 0: none.
  RequestId reading_ranges() const { return reading_ranges_; }

  /// Opens a dataset, which must not be is_open(); another one that is still being opened is given up, and who asked for it hears
  /// "cancelled". Who asks for one that is being opened waits with the first, in whose place the asker is taken if it is a viewer.
  void open(const std::string& id, Asker asker, bool reload, TimePoint now, Reply reply);
  /// Does not wait any longer for a file, if this is the operation by which everyone knows that.
  void cancel(std::uint64_t operation, TimePoint now);
  /// The catalogue has changed.
  void look_at_files(TimePoint now);
  /// A file that is waited for may not come.
  void look_at_waiting(TimePoint now);
  /// Something of it could not be read.
  void note_unread() { unread_ = true; }

 private:
  struct Opening {
    RequestId request = 0;
    std::string dataset;
    Asker asker;
    Reply reply;
    bool reload = false;
    std::string version;                   // the engine's id that was asked for
    CatalogueEntry asked;                  // as it was when it was asked for
    std::optional<RequestFailed> failure;  // it could not be read and is waited for
    TimePoint until{};                     // so long
    std::uint64_t waiting_as = 0;          // the operation by which viewers know that
    int tries = 0;
  };

  void ask();
  void answered(const EngineEvent& event, TimePoint now);
  bool waits_for_file(const RequestFailed& failed, Opening& opening, TimePoint now) const;
  void wait_for_file(TimePoint now);
  void ask_again();
  void tell_waited(bool cancelled);
  void set_facts(DatasetFacts facts);
  void set_on_disk(OnDisk what);
  void read_ranges();
  void give_up_ranges();
  void read_new_steps(int parts);

  const SessionKey session_;
  EngineDoor& engine_;
  Audience& audience_;
  std::shared_ptr<const DatasetFacts> facts_;
  std::string version_;
  int parts_ = 0;                // of it, that its times are known of
  RequestId reading_ranges_ = 0;
  RequestId reading_steps_ = 0;  // asks for the times of new ones
  bool unread_ = false;
  std::optional<Opening> opening_;
};

}  // namespace isostrata
