#include "data/histogram.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "base/parallel.h"

namespace isostrata {

Histogram histogram(const PointArray& array, int bins) {
  constexpr int kMostBins = 1 << 20;
  if (bins < 1 || bins > kMostBins)
    throw Error(ErrorCode::invalid_argument, "histogram: " + std::to_string(bins) + " bins; expected 1 to " + std::to_string(kMostBins));
  Histogram result{array.lower, array.upper, std::vector<std::int64_t>(static_cast<std::size_t>(bins), 0)};
  if (array.lower > array.upper) return result;
  // Halves first: the width of a range that spans all doubles is still finite.
  const double half_range = array.upper / 2 - array.lower / 2;
  std::mutex mutex;
  std::visit(
      [&](auto values) {
        const auto count = static_cast<std::int64_t>(values.size());
        // Large blocks, so that adding up their bins stays cheap.
        parallel_for(count, std::max<std::int64_t>(1 << 18, bins * 4ll), [&](std::int64_t begin, std::int64_t end) {
          std::vector<std::int64_t> counts(static_cast<std::size_t>(bins), 0);
          for (std::int64_t i = begin; i < end; ++i) {
            const auto value = static_cast<double>(values[static_cast<std::size_t>(i)]);
            if (!std::isfinite(value)) continue;
            const double at = half_range > 0 ? (value / 2 - array.lower / 2) / half_range : 0.5;
            ++counts[static_cast<std::size_t>(std::clamp(static_cast<std::int64_t>(at * bins), std::int64_t{0}, std::int64_t{bins} - 1))];
          }
          std::lock_guard lock(mutex);
          for (std::size_t b = 0; b < counts.size(); ++b) result.counts[b] += counts[b];
        });
      },
      array.values);
  return result;
}

}  // namespace isostrata
