#include "worker/worker_device.h"

namespace isostrata {

void WorkerDevice::draws(std::string name, Clock::time_point now) {
  if (trying_) {
    retry_.draws(now);
    instead_.clear();
  }
  trying_ = false;
  name_ = std::move(name);
}

void WorkerDevice::try_again() {
  trying_ = true;
  choice_ = asked_;
}

bool WorkerDevice::died(const std::string& cause, bool too_many, Clock::time_point now) {
  const bool trial = retry_.on_trial(now) && (trying_ || instead_.empty());
  if (!trial && !(too_many && instead_.empty())) return false;
  if (!trying_) given_up_ = name_.empty() ? "renderer " + choice_.renderer : name_;
  trying_ = false;
  instead_ = " in place of " + given_up_ + ", whose process died " +
             (trial ? "again when it was tried" : std::to_string(DeathHistory::kMost) + " times in " + std::to_string(DeathHistory::kWindow.count()) + " s") +
             ", the last time " + cause;
  if (!draws_natively()) instead_ += "; it is tried again in " + seconds_of(retry_.gave_up(now));
  choice_ = {"native", "native"};
  return true;
}

std::string seconds_of(std::chrono::milliseconds time) {
  const auto ms = time.count();
  return ms % 1000 == 0 ? std::to_string(ms / 1000) + " s" : std::to_string(ms) + " ms";
}

}  // namespace isostrata
