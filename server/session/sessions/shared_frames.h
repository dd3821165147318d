// The frames of a session: which pictures the engine is asked for, and who gets them. What is decided by a clock or by counting is decided in
// pacing; here it is asked and sent.
#pragma once

#include <functional>
#include <optional>

#include "session/datasets/engine_door.h"
#include "session/pacing/frames_in_making.h"
#include "session/pacing/making_costs.h"
#include "session/people/participants.h"

namespace isostrata {

/// Of one session. Not thread-safe: lives on the io thread.
class SharedFrames {
 public:
  struct Ports {
    std::function<void(TimePoint)> announce;  // the engine is told the newest scene, if it does not know it
    std::function<void(TimePoint)> pump;      // whatever is due in the session, pump() among it
    std::function<bool()> drawable;           // there is something to draw
    std::function<ViewerBudget&()> budget;    // of all who may only look
  };
  /// All must outlive it, and it the answers. scene: the newest.
  SharedFrames(SessionKey session, EngineDoor& engine, const Participants& people, const Scene& scene, Ports ports)
      : session_(session), engine_(engine), people_(people), scene_(scene), ports_(std::move(ports)) {}

  /// The viewer is among the people from now on.
  void come(Viewer& viewer, TimePoint now);
  /// It is about to leave them.
  void leave(Viewer& viewer);
  /// Nobody is left.
  void forget_kept() { making_.forget_kept(); }
  /// The scene has a new revision.
  void scene_changed(TimePoint now);
  /// Everyone is to get the newest picture once more.
  void draw_again(TimePoint now);
  /// The engine is told of another scene than before.
  void note_told(const Scene& before, const Scene& now);

  /// Its video cannot be decoded. again: by the decoder that it had, which begins anew; else not at all.
  void decoder_failed(Viewer& viewer, bool again, TimePoint now);
  /// Asks for what is due for this viewer, or for all.
  void pump(Viewer& viewer, TimePoint now);
  void pump(TimePoint now);
  /// When pump may have something to do without an event.
  std::optional<TimePoint> wake_at(TimePoint now) const;

 private:
  /// What the layers of a scene hold, for whoever sees them at rest.
  struct Measured {
    Scene scene;
    RequestId request = 0;                // that has not been answered; 0: none
    std::optional<v1::LayerFacts> facts;  // nothing: not known yet, or it failed
  };

  bool give_kept(Viewer& viewer, const FrameRequest& wanted, const FrameOrder& order, TimePoint now);
  bool join(Viewer& viewer, const FrameRequest& wanted, const FrameOrder& order);
  void ask(Viewer& viewer, const FrameRequest& request, const FrameOrder& order);
  FrameRequest request_of(Viewer& viewer, FrameOrder& order, TimePoint now);
  void answered(RequestId request, const EngineEvent& event, TimePoint now);
  void ready(const FramesInMaking::Making& made, const FrameReady& ready, TimePoint now);
  void failed(const FramesInMaking::Making& made, const RequestFailed& failed, TimePoint now);
  void give(Viewer& viewer, FrameOrder order, const FrameReady& ready, TimePoint now);
  void send_bands(Viewer& viewer, TimePoint now);
  void tell_layers(Viewer& viewer);
  void give_up_measuring();
  void forget(RequestId request);
  void leave_ordered(Viewer& viewer);

  void begin_stream(Viewer& viewer, TimePoint now);
  void leave_stream(Viewer& viewer, TimePoint now);
  void end_streams();
  void step_down(Viewer& viewer, TimePoint now);
  void choose_format(Viewer& viewer, TimePoint now);
  void use_format(Viewer& viewer, TimePoint now);

  const SessionKey session_;
  EngineDoor& engine_;
  const Participants& people_;
  const Scene& scene_;
  const Ports ports_;
  FramesInMaking making_;
  VideoStreams streams_;
  MakingCosts costs_;
  std::optional<Measured> measured_;
};

}  // namespace isostrata
