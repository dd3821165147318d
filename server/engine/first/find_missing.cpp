#include "engine/first/find_missing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <set>
#include <variant>

#include "base/parallel.h"
#include "data/derived/series_ranges.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostLooks = 100'000;
constexpr double kLeastShare = 0.001;   // of the points, that have it
constexpr std::size_t kLeastOthers = 8;  // different ones: else the two are phases of something
constexpr double kLeastGap = 0.5;       // of the range, between it and all others
constexpr double kMuchLarger = 1500;  // water is 860 times as dense as air

bool is_written_for_it(double value) {
  const double size = std::abs(value);
  constexpr std::array kSigned{-32767.0, -32768.0, -2147483647.0, -2147483648.0};
  constexpr std::array kSizes{99.0, 999.0, 9999.0, 99999.0, 999999.0, 9999999.0, 99999999.0, 999.9, 999.25, 9999.9};
  if (size >= 1e30) return true;  // netCDF's 9.96921e36, the largest float, 1e30 and the like
  if (std::find(kSigned.begin(), kSigned.end(), value) != kSigned.end()) return true;
  if (size >= 1e10) {
    const double power = std::pow(10, std::round(std::log10(size)));
    return std::abs(size - power) <= 1e-6 * power;  // as a float may hold it
  }
  return std::any_of(kSizes.begin(), kSizes.end(), [&](double of) { return std::abs(size - of) <= 1e-6 * of; });
}

/// The range of all finite values but one.
template <class T>
ValueRange others(std::span<const T> values, double but) {
  std::mutex mutex;
  ValueRange range;
  parallel_for(static_cast<std::int64_t>(values.size()), 1 << 18, [&](std::int64_t begin, std::int64_t end) {
    ValueRange part;
    for (const T value : values.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)))
      if (const auto v = static_cast<double>(value); std::isfinite(v) && v != but) part = {std::min(part.lower, v), std::max(part.upper, v)};
    const std::lock_guard lock(mutex);
    range = join(range, part);
  });
  return range;
}

double gap(double value, const ValueRange& range) { return value < range.lower ? range.lower - value : value - range.upper; }

bool stands_for_none(double candidate, const ValueRange& others, double width) {
  const double size = std::max(std::abs(others.lower), std::abs(others.upper));
  return gap(candidate, others) >= kLeastGap * width && (is_written_for_it(candidate) || std::abs(candidate) > kMuchLarger * size);
}

template <class T>
std::optional<MissingValue> guess(std::span<const T> values, double candidate, double width) {
  const std::size_t stride = std::max<std::size_t>(1, values.size() / kMostLooks);
  std::size_t looks = 0, found = 0;
  ValueRange range;
  std::set<double> different;
  for (std::size_t i = 0; i < values.size(); i += stride) {
    const auto v = static_cast<double>(values[i]);
    if (!std::isfinite(v)) continue;
    ++looks;
    if (v == candidate) {
      ++found;
      continue;
    }
    range = {std::min(range.lower, v), std::max(range.upper, v)};
    if (different.size() < kLeastOthers) different.insert(v);
  }
  if (static_cast<double>(found) < kLeastShare * static_cast<double>(looks) || different.size() < kLeastOthers) return std::nullopt;
  if (!stands_for_none(candidate, range, width)) return std::nullopt;
  return MissingValue{candidate, range.lower, range.upper};
}

}  // namespace

std::optional<MissingValue> guess_missing(const PointArray& array) {
  const double width = array.upper - array.lower;
  if (!(width > 0)) return std::nullopt;
  for (const double candidate : {array.lower, array.upper})
    if (auto missing = std::visit([&](auto values) { return guess(values, candidate, width); }, array.values)) return missing;
  return std::nullopt;
}

std::optional<MissingValue> find_missing(const PointArray& array) {
  const auto guessed = guess_missing(array);
  if (!guessed) return std::nullopt;
  const ValueRange range = std::visit([&](auto values) { return others(values, guessed->value); }, array.values);
  if (!stands_for_none(guessed->value, range, array.upper - array.lower)) return std::nullopt;
  return MissingValue{guessed->value, range.lower, range.upper};
}

}  // namespace isostrata
