#include "main/worker_probe.h"

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <optional>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/stopwatch.h"
#include "worker/worker_engine.h"

namespace isostrata {
namespace {

constexpr auto kLimit = std::chrono::seconds(60);  // software devices on a busy machine take seconds
constexpr SessionKey kSession = 1;

Scene small_scene() {
  Scene scene;
  scene.revision = 1;
  scene.dataset = "torus-12";
  scene.array = "distance";
  scene.camera = Camera{{3, 2, 4}, {0, 0, 0}, {0, 1, 0}, 30};
  SceneInterval interval;
  interval.id = 1;
  interval.lower = 0.2;
  interval.upper = 0.5;
  scene.intervals.push_back(interval);
  return scene;
}

/// The answers, as they come from the engine's threads. Lock: mutex_.
class Answers {
 public:
  void take(EngineEvent event) {
    {
      const std::lock_guard lock(mutex_);
      events_.push_back(std::move(event));
    }
    came_.notify_all();
  }
  /// Throws what the engine says instead of a frame, and unavailable if it says nothing in time.
  FrameReady frame_of(RequestId request) {
    std::unique_lock lock(mutex_);
    std::optional<FrameReady> frame;
    std::optional<RequestFailed> failed;
    came_.wait_for(lock, kLimit, [&] {
      for (const EngineEvent& event : events_) {
        if (const auto* ready = std::get_if<FrameReady>(&event); ready && ready->request == request) frame = *ready;
        if (const auto* no = std::get_if<RequestFailed>(&event); no && no->request == request) failed = *no;
      }
      return frame || failed;
    });
    if (failed) throw Error(failed->code, failed->message);
    if (!frame) throw Error(ErrorCode::unavailable, "no frame came within " + std::to_string(kLimit.count()) + " s");
    return *frame;
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<EngineEvent> events_;
};

FrameRequest small_frame(RequestId request) {
  FrameRequest wanted;
  wanted.session = kSession;
  wanted.request = request;
  wanted.width = 64;
  wanted.height = 48;
  return wanted;
}

std::string pid_text(std::int64_t pid) { return "process " + std::to_string(pid); }

}  // namespace

WorkerProbe probe_worker(const RendererChoice& choice) {
  WorkerProbe probe;
  try {
    Answers answers;
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:12"});
    options.renderer_choice = choice;
    const Stopwatch starting;
    WorkerOptions worker;
    worker.plan.shut_in = true;  // as serve's
    WorkerEngine engine(std::move(options), std::move(worker), [&answers](EngineEvent event) { answers.take(std::move(event)); });
    probe.start_ms = starting.elapsed_ms();
    const std::int64_t first = engine.facts().process;
    probe.shut_in = engine.facts().shut_in;
    probe.detail = pid_text(first) + " started";

    const Stopwatch drawing;
    engine.post(SceneUpdate{kSession, small_scene()});
    engine.post(small_frame(1));
    probe.device = answers.frame_of(1).device;
    probe.frame_ms = drawing.elapsed_ms();
    probe.detail += " and drew";

    if (first <= 1 || kill(static_cast<pid_t>(first), SIGKILL) != 0)
      throw Error(ErrorCode::internal, pid_text(first) + " cannot be killed");
    const Stopwatch replacing;
    engine.post(small_frame(2));
    answers.frame_of(2);
    probe.replace_ms = replacing.elapsed_ms();
    const std::int64_t second = engine.facts().process;
    if (second == first) throw Error(ErrorCode::internal, pid_text(first) + " was killed and seems to draw");
    probe.detail += "; killed, it was replaced by " + pid_text(second) + ", which drew the same scene";
    probe.ok = true;
  } catch (const Error& error) {
    probe.detail += (probe.detail.empty() ? "" : "; then: ") + std::string(error.what());
  }
  return probe;
}

}  // namespace isostrata
