// A counter that work moves as it goes on, so that whoever watches it can tell slow from stuck.
#pragma once

#include <atomic>
#include <cstdint>

namespace isostrata {

using Pulse = std::atomic<std::uint64_t>;  // may lie in shared memory

/// While it lives, pulse() on this thread moves `of` (null: nothing). parallel_for carries it into its loops and moves it at
/// every block, so that work made of loops has a pulse without saying so.
class PulseScope {
 public:
  explicit PulseScope(Pulse* of);
  ~PulseScope();
  PulseScope(const PulseScope&) = delete;
  PulseScope& operator=(const PulseScope&) = delete;

 private:
  Pulse* const before_;
};

/// Of this thread; null if there is none.
Pulse* current_pulse();
void pulse();

}  // namespace isostrata
