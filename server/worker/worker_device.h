// Which device the next worker draws on: the one that was asked for, or native where its processes keep dying.
#pragma once

#include <chrono>
#include <string>
#include <utility>

#include "rendering/picture/renderer.h"
#include "worker/death_history.h"

namespace isostrata {

/// Pure decisions on times that are passed in. Not thread-safe.
class WorkerDevice {
 public:
  using Clock = std::chrono::steady_clock;

  /// retry_pause: as WorkerOptions.
  WorkerDevice(RendererChoice asked, std::chrono::milliseconds retry_pause) : asked_(std::move(asked)), choice_(asked_), retry_(retry_pause) {}

  const RendererChoice& choice() const { return choice_; }
  /// What workers have drawn on; empty before the first could.
  const std::string& name() const { return name_; }
  /// " in place of ..., whose process died ...": behind the device's name in every frame; empty while nothing was given up.
  const std::string& instead() const { return instead_; }
  bool is_native() const { return !instead_.empty() || draws_natively(); }

  /// A worker can draw, on this one.
  void draws(std::string name, Clock::time_point now);
  /// Whether the one that was given up is due again.
  bool retry_is_due(Clock::time_point now) const { return !instead_.empty() && retry_.due(now); }
  void try_again();
  /// A worker died; too_many: as DeathHistory. Says whether it is given up: `cause` is why the last one died. Nothing is, if there is nothing to fall back
  /// to.
  bool died(const std::string& cause, bool too_many, Clock::time_point now);

 private:
  bool draws_natively() const { return choice_.renderer == "native" || choice_.device == "native"; }

  const RendererChoice asked_;
  RendererChoice choice_;
  DeviceRetry retry_;
  std::string name_, instead_;
  std::string given_up_;  // that instead_ speaks of
  bool trying_ = false;   // the next worker is on the device that was given up
};

/// "3 s", "250 ms".
std::string seconds_of(std::chrono::milliseconds time);

}  // namespace isostrata
