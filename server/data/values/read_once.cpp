#include "data/values/read_once.h"

#include <algorithm>
#include <array>
#include <mutex>

#include "base/parallel.h"

namespace isostrata {

void read_once(const PointArray& array) {
  std::visit(
      [](auto values) {
        using T = std::remove_const_t<typename decltype(values)::element_type>;
        std::mutex mutex;
        T lowest = values[0], highest = values[0];
        parallel_for(static_cast<std::int64_t>(values.size()), 1 << 18, [&](std::int64_t begin, std::int64_t end) {
          constexpr int kLanes = 16;  // independent, so that the compiler may use vectors
          std::array<T, kLanes> lo, hi;
          lo.fill(values[begin]);
          hi.fill(values[begin]);
          std::int64_t i = begin;
          for (; i + kLanes <= end; i += kLanes)
            for (int k = 0; k < kLanes; ++k) {
              const T v = values[i + k];
              lo[k] = v < lo[k] ? v : lo[k];
              hi[k] = v > hi[k] ? v : hi[k];
            }
          for (; i < end; ++i) {
            lo[0] = std::min(lo[0], values[i]);
            hi[0] = std::max(hi[0], values[i]);
          }
          std::lock_guard lock(mutex);
          lowest = std::min(lowest, *std::min_element(lo.begin(), lo.end()));
          highest = std::max(highest, *std::max_element(hi.begin(), hi.end()));
        });
        [[maybe_unused]] volatile T keep = lowest;
        keep = highest;
      },
      array.values);
}

}  // namespace isostrata
