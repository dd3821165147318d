// How many lines of one kind a log takes: what a client can cause thousands of times a second must not fill a disk.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace isostrata {

/// Not thread-safe.
class LineBudget {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// At most `lines` in each `window`, which begins with the first line after the last one has passed.
  LineBudget(int lines, std::chrono::steady_clock::duration window) : lines_(lines), window_(window) {}

  /// Whether a line may be written now: then how many before it were left out since the last one that was written.
  std::optional<std::uint64_t> take(TimePoint now) {
    if (!began_ || now - *began_ >= window_) {
      began_ = now;
      taken_ = 0;
    }
    if (taken_ >= lines_) {
      ++left_out_;
      return std::nullopt;
    }
    ++taken_;
    const std::uint64_t left_out = left_out_;
    left_out_ = 0;
    return left_out;
  }

 private:
  const int lines_;
  const std::chrono::steady_clock::duration window_;
  std::optional<TimePoint> began_;
  int taken_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace isostrata
