// Renderers that need no device, kept between drawings: what they have made of a mesh serves the next picture of it.
#pragma once

#include <list>
#include <memory>
#include <mutex>

#include "engine/messages/messages.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// Any thread may call any function. Lock: mutex_.
class KeptRenderers {
 public:
  static constexpr std::size_t kMost = 6;  // that nobody uses; their memory grows with meshes

  /// That of the session's last frame, or still; null if it is not kept.
  std::unique_ptr<Renderer> take(SessionKey session, bool still) {
    const std::lock_guard lock(mutex_);
    for (auto it = kept_.begin(); it != kept_.end(); ++it)
      if (it->session == session && it->still == still) {
        auto renderer = std::move(it->renderer);
        kept_.erase(it);
        return renderer;
      }
    return nullptr;
  }
  void give(SessionKey session, bool still, std::unique_ptr<Renderer> renderer) {
    std::list<Kept> dropped;  // freed without the lock
    const std::lock_guard lock(mutex_);
    kept_.push_front({session, still, std::move(renderer)});
    if (kept_.size() > kMost) dropped.splice(dropped.end(), kept_, std::prev(kept_.end()));
  }
  void drop(SessionKey session) {
    std::list<Kept> dropped;
    const std::lock_guard lock(mutex_);
    for (auto it = kept_.begin(); it != kept_.end();) {
      const auto next = std::next(it);
      if (it->session == session) dropped.splice(dropped.end(), kept_, it);
      it = next;
    }
  }

 private:
  struct Kept {
    SessionKey session = 0;
    bool still = false;
    std::unique_ptr<Renderer> renderer;
  };
  std::mutex mutex_;
  std::list<Kept> kept_;  // the last used first
};

}  // namespace isostrata
