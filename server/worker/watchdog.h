// Slow or stuck: what a board says of each thread, over time. Pure decisions on times that the caller passes in.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "engine/messages/activity.h"

namespace isostrata {

/// Not thread-safe.
class Watchdog {
 public:
  using Duration = std::chrono::milliseconds;
  Watchdog(Duration soft, Duration hard) : soft_(soft), hard_(hard) {}

  struct Verdict {
    bool hanging = false;              // the render thread, or a drawing, has passed the soft limit
    bool hung = false;                 // something has passed its last limit
    std::vector<ActivityFacts> stuck;  // other threads that have just become late: cancelling may help
    Duration silent{0};                // the longest silence in units of the usual patience, of what hangs
    double fraction = 0;               // of the way to the end, of that which is nearest to it
    Stage stage = Stage::idle;         // of what hangs
  };
  /// passed: since the last look. A look that comes late counts little: then whoever looks was stopped itself. ready: the worker
  /// has said that it can draw; until then it has kStarting times as long.
  Verdict look(const std::vector<ActivityFacts>& at, Duration passed, bool ready);

  static constexpr int kStarting = 12;
  static constexpr int kCancelled = 3;     // times the hard limit: work of another thread is cancelled,
  static constexpr int kOtherThreads = 6;  // and then it is hung; it may have phases without a pulse, and others draw meanwhile

 private:
  struct Seen {
    Stage stage = Stage::idle;
    std::uint64_t session = 0, request = 0, pulse = 0;
    Duration silent{0};
    bool cancelled = false;
  };
  const Duration soft_, hard_;
  std::map<std::size_t, Seen> seen_;  // by slot
};

}  // namespace isostrata
