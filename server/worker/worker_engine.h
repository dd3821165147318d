// An engine in a process of its own. The worker may crash, hang or be killed: it is replaced, is told the scenes again, and what
// was asked of it is asked again; sessions see late frames and no errors. What keeps dying is drawn by another renderer, with the
// cause named in every frame; a scene or a request that keeps killing workers is refused.
//
// Threads: one that keeps the worker alive and watches it, and for each worker one that reads from it and one that writes to it.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/engine/engine.h"
#include "worker/launcher.h"

namespace isostrata {

struct WorkerOptions {
  WorkerPlan plan;                     // of those that this process starts
  std::shared_ptr<Launcher> launcher;  // who starts them in its place; empty: this process
  int threads = 0;                               // as set_thread_count, in the worker
  // Without a sign of life from the thread that draws, if it is idle or draws by loops of ours; what a device draws gets more
  // by its size (Activity::patience). Other threads have six times as long.
  std::chrono::milliseconds soft_limit{2000};   // viewers are told, and may give the worker up
  std::chrono::milliseconds hard_limit{10000};  // it is killed
  /// After the device has been given up: how long until it is tried again, twice as long after every try that fails, up to an
  /// hour.
  std::chrono::milliseconds retry_pause{60000};
  /// What people should know: a short name of the event ("worker_died") and a sentence. Called from the engine's threads.
  std::function<void(std::string_view event, const std::string& text)> log;
};

class WorkerEngine final : public FrameEngine {
 public:
  /// Waits for the first worker that can draw. Of `engine`, `renderer`, `fallback_renderer` and `board` are not looked at.
  /// Throws what the worker's engine throws (no device can draw, words that are none), and unavailable if workers die at once.
  WorkerEngine(EngineOptions engine, WorkerOptions worker, Sink sink);
  /// Ends the worker; no event comes afterwards.
  ~WorkerEngine() override;

  void post(EngineRequest request) override;
  const Catalogue& catalogue() const override;
  std::string device() const override;
  EngineFacts facts() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isostrata
