// What an engine has said, and what tests ask of it.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "engine/messages/messages.h"

namespace isostrata {

/// Events from any thread, kept in their order. For fixtures.
class HeardEvents {
 protected:
  void note(EngineEvent event) {
    std::lock_guard lock(mutex_);
    events_.push_back(std::move(event));
    changed_.notify_all();
  }
#ifdef ISOSTRATA_SANITIZED
  static constexpr std::chrono::minutes kLongest{10};
#else
  static constexpr std::chrono::minutes kLongest{1};
#endif
  /// The first event that fits; fails the test if none comes within kLongest.
  template <class Event>
  Event wait_for(const std::function<bool(const Event&)>& fits) {
    std::unique_lock lock(mutex_);
    std::optional<Event> found;
    changed_.wait_for(lock, kLongest, [&] {
      for (const EngineEvent& event : events_)
        if (const auto* e = std::get_if<Event>(&event); e && fits(*e)) {
          found = *e;
          return true;
        }
      return false;
    });
    EXPECT_TRUE(found) << "no such event among " << events_.size();
    return found.value_or(Event{});
  }
  FrameReady frame_of(RequestId request) {
    return wait_for<FrameReady>([=](const FrameReady& f) { return f.request == request; });
  }
  RequestFailed failure_of(RequestId request) {
    return wait_for<RequestFailed>([=](const RequestFailed& f) { return f.request == request; });
  }

  static Scene scene(std::uint64_t revision, double upper = 0.5, const std::string& dataset = "torus-12") {
    Scene scene;
    scene.revision = revision;
    scene.dataset = dataset;
    scene.array = "distance";
    scene.camera = Camera{{3, 2, 4}, {0, 0, 0}, {0, 1, 0}, 30};
    scene.intervals.push_back({1, 0.2, upper, {1, 0, 0}, "", 0.5, 0, true});
    return scene;
  }
  static FrameRequest frame(SessionKey session, RequestId request, bool lossless = false) {
    FrameRequest wanted;
    wanted.session = session;
    wanted.request = request;
    wanted.width = 16;
    wanted.height = 12;
    wanted.lossless = lossless;
    wanted.jpeg = !lossless;
    return wanted;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<EngineEvent> events_;
};

}  // namespace isostrata
