// Who offers wrong tokens waits for the answers, longer each time, so that no token is found by trying.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>

namespace isostrata {

/// By address. A right token is never delayed, so that nobody is shut out by others who share an address (a tunnel's, a proxy's).
/// Not thread-safe: lives on the io thread.
class WrongTokens {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr int kFree = 10;                         // mistakes of a person, or of a page that was open before a restart
  static constexpr std::chrono::milliseconds kFirst{100};  // then doubled each time
  static constexpr std::chrono::milliseconds kLongest{5000};
  static constexpr std::chrono::seconds kForgiven{60};  // one mistake in that time
  static constexpr std::size_t kMostAddresses = 4096;   // whoever has the least mistakes is forgotten first

  /// Counts one more, and says how long its answer is to wait.
  std::chrono::milliseconds note(const std::string& address, Clock::time_point now);

 private:
  struct Mistakes {
    int count = 0;
    Clock::time_point last;
  };
  std::map<std::string, Mistakes> of_;
};

}  // namespace isostrata
