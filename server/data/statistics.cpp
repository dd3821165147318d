#include "data/statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr std::int64_t kChunk = 1 << 16;  // fixed: the chunks, and with them the last bits, are the same on any machine

/// Of values counted from an origin among them: those that are large and lie close together would else lose their last digits.
struct Moments {
  std::int64_t finite = 0, nan = 0, infinite = 0;
  double mean = 0, squares = 0;  // sum of squared differences from the mean
};

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

}  // namespace

Statistics statistics(const PointArray& array) {
  // Squares of values beyond the square root of the largest double would overflow: those are measured in larger units.
  const double widest = std::max(std::abs(array.lower), std::abs(array.upper));
  const double scale = std::isfinite(widest) && widest > 1e150 ? 1e-200 : 1;
  const double origin = std::isfinite(widest) ? (array.lower * scale + array.upper * scale) / 2 : 0;
  return std::visit(
      [&](auto values) {
        const auto count = static_cast<std::int64_t>(values.size());
        std::vector<Moments> chunks(static_cast<std::size_t>((count + kChunk - 1) / kChunk));
        parallel_for(static_cast<std::int64_t>(chunks.size()), 4, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t c = begin; c < end; ++c)
            chunks[static_cast<std::size_t>(c)] =
                moments_of(values, c * kChunk, std::min(count, (c + 1) * kChunk), scale, origin);
        });
        while (chunks.size() > 1) {
          for (std::size_t i = 0; 2 * i < chunks.size(); ++i)
            chunks[i] = 2 * i + 1 < chunks.size() ? combined(chunks[2 * i], chunks[2 * i + 1]) : chunks[2 * i];
          chunks.resize((chunks.size() + 1) / 2);
        }
        const Moments m = chunks.empty() ? Moments{} : chunks.front();
        Statistics s{m.finite, m.nan, m.infinite, array.lower, array.upper};
        s.mean = (m.mean + origin) / scale;
        if (m.finite > 0) s.standard_deviation = std::sqrt(m.squares / static_cast<double>(m.finite)) / scale;
        return s;
      },
      array.values);
}

}  // namespace isostrata
