#include "net/http/wrong_tokens.h"

#include <algorithm>

namespace isostrata {

std::chrono::milliseconds WrongTokens::note(const std::string& address, Clock::time_point now) {
  if (of_.size() >= kMostAddresses && !of_.contains(address))
    of_.erase(
        std::min_element(of_.begin(), of_.end(), [](const auto& a, const auto& b) { return a.second.count < b.second.count; }));
  Mistakes& mistakes = of_[address];
  if (mistakes.count > 0) {
    const auto forgiven = (now - mistakes.last) / kForgiven;
    mistakes.count = static_cast<int>(std::max<long long>(0, mistakes.count - static_cast<long long>(forgiven)));
  }
  mistakes.last = now;
  constexpr int kMostCounted = kFree + 16;  // so that forgiveness is a matter of minutes
  mistakes.count = std::min(mistakes.count + 1, kMostCounted);
  if (mistakes.count <= kFree) return std::chrono::milliseconds(0);
  return std::min(kLongest, kFirst * (1 << (mistakes.count - kFree - 1)));
}

}  // namespace isostrata
