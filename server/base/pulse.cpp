#include "base/pulse.h"

#include <utility>

namespace isostrata {
namespace {
thread_local Pulse* current = nullptr;
}

PulseScope::PulseScope(Pulse* of) : before_(std::exchange(current, of)) {}
PulseScope::~PulseScope() { current = before_; }

Pulse* current_pulse() { return current; }

void pulse() {
  if (current) current->fetch_add(1, std::memory_order_relaxed);
}

}  // namespace isostrata
