#include "data/values/histogram.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <span>
#include <string>

#include "base/parallel.h"
#include "data/values/kept_facts.h"

namespace isostrata {
namespace {

void check_bins(int bins) {
  constexpr int kMostBins = 1 << 20;
  if (bins < 1 || bins > kMostBins)
    throw Error(ErrorCode::invalid_argument,
                "histogram: " + std::to_string(bins) + " bins; expected 1 to " + std::to_string(kMostBins));
}

}  // namespace

std::vector<std::uint64_t> histogram(const PointArray& array, double lower, double upper, int bins) {
  check_bins(bins);
  if (!std::isfinite(lower) || !std::isfinite(upper) || lower > upper)
    throw Error(ErrorCode::invalid_argument, "histogram: from " + std::to_string(lower) + " to " + std::to_string(upper) +
                                                 "; expected finite limits, lower first");
  // Halves first: the width of a range that spans all doubles is still finite.
  const double half_range = upper / 2 - lower / 2;
  std::vector<std::uint64_t> total(static_cast<std::size_t>(bins), 0);
  std::mutex mutex;
  std::visit(
      [&](auto values) {
        const auto count = static_cast<std::int64_t>(values.size());
        // Large blocks, so that adding up their bins stays cheap.
        parallel_for(count, std::max<std::int64_t>(1 << 18, bins * 4ll), [&](std::int64_t begin, std::int64_t end) {
          std::vector<std::uint64_t> counts(static_cast<std::size_t>(bins), 0);
          for (std::int64_t i = begin; i < end; ++i) {
            const auto value = static_cast<double>(values[static_cast<std::size_t>(i)]);
            if (!(value >= lower && value <= upper)) continue;  // also NaN
            const double at = half_range > 0 ? (value / 2 - lower / 2) / half_range : 0.5;
            ++counts[static_cast<std::size_t>(std::min(static_cast<std::int64_t>(at * bins), std::int64_t{bins} - 1))];
          }
          std::lock_guard lock(mutex);
          for (std::size_t b = 0; b < counts.size(); ++b) total[b] += counts[b];
        });
      },
      array.values);
  return total;
}

Histogram histogram(const PointArray& array, int bins) {
  check_bins(bins);
  if (array.lower > array.upper) return {array.lower, array.upper, std::vector<std::uint64_t>(static_cast<std::size_t>(bins), 0)};
  return {array.lower, array.upper, histogram(array, array.lower, array.upper, bins)};
}

std::vector<std::uint64_t> kept_histogram(const PointArray& array, double lower, double upper, int bins) {
  constexpr int kMostKept = 1 << 14;
  const bool all = lower == array.lower && upper == array.upper && bins >= 1 && bins <= kMostKept;
  const std::string name = "histogram-" + std::to_string(bins);
  std::vector<std::uint64_t> counts(all ? static_cast<std::size_t>(bins) : 0);
  if (const auto kept = all ? kept_fact(array, name) : std::nullopt; kept && kept->size() == counts.size() * sizeof counts[0]) {
    std::memcpy(counts.data(), kept->data(), kept->size());
    return counts;
  }
  counts = histogram(array, lower, upper, bins);
  if (all) keep_fact(array, name, std::as_bytes(std::span<const std::uint64_t>(counts)));
  return counts;
}

}  // namespace isostrata
