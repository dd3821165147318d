#include "data/values/statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "data/values/moments.h"

namespace isostrata {
namespace {

constexpr std::int64_t kChunk = 1 << 16;  // fixed: the chunks, and with them the last bits, are the same on any machine

template <class Values>
Moments moments_of(Values values, std::int64_t begin, std::int64_t end, double scale, double origin) {
  Moments m;
  double sum = 0;
  for (std::int64_t i = begin; i < end; ++i) {
    const double v = static_cast<double>(values[static_cast<std::size_t>(i)]) * scale - origin;
    if (std::isfinite(v))
      ++m.finite, sum += v;
    else
      ++(std::isnan(v) ? m.nan : m.infinite);
  }
  if (m.finite == 0) return m;
  m.mean = sum / static_cast<double>(m.finite);
  for (std::int64_t i = begin; i < end; ++i) {
    const double v = static_cast<double>(values[static_cast<std::size_t>(i)]) * scale - origin;
    if (std::isfinite(v)) m.squares += (v - m.mean) * (v - m.mean);
  }
  return m;
}

struct Unit {
  double scale = 1, origin = 0;
};
Unit unit_of(double lower, double upper) {
  // Squares of values beyond the square root of the largest double would overflow: those are measured in larger units.
  const double widest = std::max(std::abs(lower), std::abs(upper));
  const double scale = std::isfinite(widest) && widest > 1e150 ? 1e-200 : 1;
  return {scale, std::isfinite(widest) ? (lower * scale + upper * scale) / 2 : 0};
}

}  // namespace

Moments combined(const Moments& a, const Moments& b) {
  Moments m{a.finite + b.finite, a.nan + b.nan, a.infinite + b.infinite};
  if (a.finite == 0 || b.finite == 0) {
    m.mean = a.finite == 0 ? b.mean : a.mean;
    m.squares = a.squares + b.squares;
    return m;
  }
  const double share = static_cast<double>(b.finite) / static_cast<double>(m.finite);
  const double difference = b.mean - a.mean;
  m.mean = a.mean + difference * share;
  m.squares = a.squares + b.squares + difference * difference * share * static_cast<double>(a.finite);
  return m;
}

Moments moments(const PointArray& part, double lower, double upper) {
  const Unit unit = unit_of(lower, upper);
  return std::visit(
      [&](auto values) {
        const auto count = static_cast<std::int64_t>(values.size());
        std::vector<Moments> chunks(static_cast<std::size_t>((count + kChunk - 1) / kChunk));
        parallel_for(static_cast<std::int64_t>(chunks.size()), 4, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t c = begin; c < end; ++c)
            chunks[static_cast<std::size_t>(c)] =
                moments_of(values, c * kChunk, std::min(count, (c + 1) * kChunk), unit.scale, unit.origin);
        });
        while (chunks.size() > 1) {
          for (std::size_t i = 0; 2 * i < chunks.size(); ++i)
            chunks[i] = 2 * i + 1 < chunks.size() ? combined(chunks[2 * i], chunks[2 * i + 1]) : chunks[2 * i];
          chunks.resize((chunks.size() + 1) / 2);
        }
        return chunks.empty() ? Moments{} : chunks.front();
      },
      part.values);
}

Statistics statistics_of(const Moments& all, double lower, double upper) {
  const Unit unit = unit_of(lower, upper);
  Statistics s{all.finite, all.nan, all.infinite, lower, upper};
  s.mean = (all.mean + unit.origin) / unit.scale;
  if (all.finite > 0) s.standard_deviation = std::sqrt(all.squares / static_cast<double>(all.finite)) / unit.scale;
  return s;
}

Statistics statistics(const PointArray& array) { return statistics_of(moments(array, array.lower, array.upper), array.lower, array.upper); }

}  // namespace isostrata
