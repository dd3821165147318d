// A stopwatch on the steady clock.
#pragma once

#include <chrono>

namespace isostrata {

class Stopwatch {
 public:
  double elapsed_ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }
  /// The time since construction or the last lap, in milliseconds; starts the next lap.
  double lap_ms() {
    const double ms = elapsed_ms();
    start_ = std::chrono::steady_clock::now();
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace isostrata
