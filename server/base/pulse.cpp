#include "base/pulse.h"

#include <utility>

namespace isostrata {
namespace {
thread_local Pulse* beating = nullptr;
}

PulseScope::PulseScope(Pulse* of) : before_(std::exchange(beating, of)) {}
PulseScope::~PulseScope() { beating = before_; }

Pulse* current_pulse() { return beating; }

void pulse() {
  if (beating) beating->fetch_add(1, std::memory_order_relaxed);
}

}  // namespace isostrata
