// How long something takes: minimum, median and maximum of several runs, and the processors' time beside the clock's.
#pragma once

#include <functional>
#include <vector>

#include "base/stopwatch.h"

namespace isostrata::peers {

struct Sample {
  double ms = 0;
  double cpu_ms = 0;  // of all threads of this process together
};

/// From its making: how long, and how much of the processors.
class Clock {
 public:
  Clock();
  Sample elapsed() const;

 private:
  Stopwatch watch_;
  double cpu_before_;
};

struct Spread {
  int runs = 0;                         // 0: not run, and the rest means nothing
  double min = 0, median = 0, max = 0;  // ms
  double cpu_median = 0;                // ms
};

Spread spread_of(const std::vector<Sample>& samples);

struct RunLimits {
  int least = 1, most = 1;
  double budget_ms = 0;  // no further run begins once this has passed, but for the least ones
};

/// Calls work(), timed, then after(), untimed, as often as the limits say, and appends to samples.
void sample(const RunLimits& limits, const std::function<void()>& work, const std::function<void()>& after,
            std::vector<Sample>& samples);

}  // namespace isostrata::peers
