#include "extraction/cells/point_table.h"

#include <algorithm>
#include <bit>

#include "base/parallel.h"

namespace isostrata {
namespace {
constexpr std::int64_t kSlotsPerBlock = 1 << 15;
}

PointTable::PointTable(std::uint32_t slots, bool bounded, const Task& task)
    : keys_(slots), first_(slots), mask_(slots - 1), bounded_(bounded) {
  parallel_for(slots, kSlotsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    std::fill(keys_.begin() + begin, keys_.begin() + end, kEmpty);
    std::fill(first_.begin() + begin, first_.begin() + end, ~std::uint32_t{0});
  });
}

Buffer<std::uint64_t> PointTable::number_keys(std::uint64_t uses, const Task& task) {
  std::vector<std::uint64_t> is_first(uses / 64 + 1);      // bit u % 64 of word u / 64: use u is the first of its key
  std::vector<std::uint32_t> before(is_first.size() + 1);  // first uses in earlier words
  const auto slots = static_cast<std::int64_t>(keys_.size());
  parallel_for(slots, kSlotsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t slot = begin; slot < end; ++slot)
      if (keys_[slot] != kEmpty)
        std::atomic_ref(is_first[first_[slot] / 64]).fetch_or(std::uint64_t{1} << first_[slot] % 64, std::memory_order_relaxed);
  });
  for (std::size_t w = 0; w < is_first.size(); ++w)
    before[w + 1] = before[w] + static_cast<std::uint32_t>(std::popcount(is_first[w]));
  Buffer<std::uint64_t> keys(before.back());
  parallel_for(slots, kSlotsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t slot = begin; slot < end; ++slot) {
      if (keys_[slot] == kEmpty) continue;
      const std::uint32_t use = first_[slot];
      const std::uint64_t earlier = is_first[use / 64] & ((std::uint64_t{1} << use % 64) - 1);
      first_[slot] = before[use / 64] + static_cast<std::uint32_t>(std::popcount(earlier));
      keys[first_[slot]] = keys_[slot];
    }
  });
  return keys;
}

}  // namespace isostrata
