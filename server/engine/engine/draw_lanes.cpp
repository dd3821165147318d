#include "engine/engine/draw_lanes.h"

#include <utility>

namespace isostrata {

void DrawLanes::draw_by(Make make, std::string instead) {
  const std::lock_guard lock(mutex_);
  make_ = std::move(make);
  instead_ = std::move(instead);
}

void DrawLanes::post(SessionKey session, PictureKind kind) {
  (kind == PictureKind::still ? stills_ : frame_lanes_).post(session, [this, session, kind] { draw(session, kind); });
}

void DrawLanes::draw(SessionKey session, PictureKind kind) {
  std::optional<PictureOrder> order = ports_.next(session, kind);
  if (!order) return;
  Make make;
  std::string instead;
  {
    const std::lock_guard lock(mutex_);
    make = make_;
    instead = instead_;
  }
  const bool still = kind == PictureKind::still;
  std::unique_ptr<Renderer> renderer = kept_.take(session, still);
  try {
    if (!renderer) renderer = make();
    frames_.draw(*renderer, std::move(*order), instead, FrameMaker::On::lane);
  } catch (...) {
    frames_.fail(*order, std::current_exception());
  }
  ports_.if_there(session, [&] {
    if (renderer) kept_.give(session, still, std::move(renderer));
  });
  ports_.free(session, kind);
}

}  // namespace isostrata
