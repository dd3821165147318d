#include "worker/watchdog.h"

#include <algorithm>
#include <utility>

namespace isostrata {

constexpr Watchdog::Duration kLongestLook{300};

Watchdog::Verdict Watchdog::look(const std::vector<ActivityFacts>& at, Duration passed, bool ready) {
  passed = std::min(passed, kLongestLook);
  Verdict verdict;
  std::map<std::size_t, Seen> now;
  for (const ActivityFacts& of : at) {
    Seen seen{of.stage, of.session, of.request, of.pulse};
    if (const auto before = seen_.find(of.slot); before != seen_.end()) {
      const Seen& was = before->second;
      if (was.pulse == seen.pulse && was.stage == seen.stage && was.session == seen.session && was.request == seen.request) {
        seen.silent = was.silent + passed;
        seen.cancelled = was.cancelled;
      }
    }
    if (of.slot == ActivityBoard::kRenderThread || of.stage == Stage::drawing) {
      const int patience = ready ? static_cast<int>(std::clamp(of.patience, 1u, 1000u)) : kStarting;
      const double fraction = static_cast<double>(seen.silent.count()) / static_cast<double>((hard_ * patience).count());
      if (fraction > verdict.fraction && !verdict.hung) {
        verdict.fraction = fraction;
        if (seen.silent >= soft_ * patience) {
          verdict.hanging = true;
          verdict.hung = seen.silent >= hard_ * patience;
          verdict.silent = seen.silent;
          verdict.stage = of.stage;
        }
      }
    } else if (ready && seen.silent >= hard_ * kCancelled) {
      if (!std::exchange(seen.cancelled, true)) verdict.stuck.push_back(of);
      if (seen.silent >= hard_ * kOtherThreads && !verdict.hung) {
        verdict.hung = true;
        verdict.silent = seen.silent;
        verdict.stage = of.stage;
      }
    }
    now[of.slot] = seen;
  }
  seen_ = std::move(now);
  return verdict;
}

}  // namespace isostrata
