// Where pictures are drawn by renderers that need no device: each session draws for itself, its stills beside its frames.
#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "engine/engine/draw_queue.h"
#include "engine/engine/frame_maker.h"
#include "engine/engine/kept_renderers.h"
#include "engine/engine/lanes.h"
#include "engine/messages/messages.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// A lane draws one picture at a time, so that others who wait for a thread have their turn. Any thread may call any function but the destructor, which
/// drops what has not begun and waits for the rest; what was given by reference must outlive it. Lock: mutex_, while nothing else is called.
class DrawLanes {
 public:
  using Make = std::function<std::unique_ptr<Renderer>()>;
  /// Who knows the sessions. Called on a lane's thread, without a lock.
  struct Ports {
    /// What the session's lane draws next. Nothing: its lane is free.
    std::function<std::optional<PictureOrder>(SessionKey session, PictureKind kind)> next;
    /// As FrameMaker::Ports.
    std::function<bool(SessionKey session, const std::function<void()>& then)> if_there;
    /// The session's lane is free, and may be posted again.
    std::function<void(SessionKey session, PictureKind kind)> free;
  };

  DrawLanes(FrameMaker& frames, KeptRenderers& kept, Ports ports) : frames_(frames), kept_(kept), ports_(std::move(ports)) {}

  /// Which renderers draw from now on. instead: what they replace and why; empty: they are those that were asked for.
  void draw_by(Make make, std::string instead);
  /// Has the session's next picture of the kind drawn. One that was posted and has not called Ports::free must not be posted again.
  void post(SessionKey session, PictureKind kind);

 private:
  void draw(SessionKey session, PictureKind kind);

  static constexpr int kStills = 4;  // sessions whose stills are drawn at once: each holds a picture
  FrameMaker& frames_;
  KeptRenderers& kept_;
  const Ports ports_;
  std::mutex mutex_;  // guards the next two
  Make make_;
  std::string instead_;
  Lanes stills_{{kStills, 0}};  // by session
  Lanes frame_lanes_;           // by session
};

}  // namespace isostrata
