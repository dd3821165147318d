// Lists of small values under integer keys, filled in parallel by counting: the hash table of this room.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {

/// The values under each key in [0, keys). Their order within a list depends on threads: sort each list before reading anything
/// into it.
template <class Value>
struct KeyedLists {
  std::vector<std::uint32_t> first;  // [keys + 1] into values
  std::vector<Value> values;

  std::int64_t keys() const { return static_cast<std::int64_t>(first.size()) - 1; }
  std::span<const Value> of(std::int64_t key) const { return {values.data() + first[key], values.data() + first[key + 1]}; }
  std::span<Value> of(std::int64_t key) { return {values.data() + first[key], values.data() + first[key + 1]}; }
};

/// Turns counts into where each list begins and returns the total. counts has one more entry, for the end.
inline std::uint64_t running_sum(std::vector<std::uint32_t>& counts) {
  std::uint64_t sum = 0;
  for (std::uint32_t& count : counts) {
    const std::uint32_t own = count;
    count = static_cast<std::uint32_t>(sum);
    sum += own;
  }
  return sum;
}

/// Calls visit(begin, end, emit) twice over blocks of [0, count); visit calls emit(key, value), both times alike.
/// O(count + keys + values). Throws too_large (`what` says of what): above max_bytes or 2^32 values; and whatever visit throws.
template <class Value, class Visit>
KeyedLists<Value> list_by_key(std::int64_t keys, std::int64_t count, std::int64_t grain, const std::string& what,
                              std::uint64_t max_bytes, const Visit& visit) {
  KeyedLists<Value> lists;
  lists.first.assign(keys + 1, 0);
  std::atomic<std::uint64_t> total{0};
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    std::uint64_t own = 0;
    visit(begin, end, [&](std::int64_t key, const Value&) {
      std::atomic_ref(lists.first[key]).fetch_add(1, std::memory_order_relaxed);
      ++own;
    });
    total.fetch_add(own, std::memory_order_relaxed);
  });
  check_budget(what, total.load() * sizeof(Value) + lists.first.size() * 2 * sizeof(std::uint32_t), max_bytes);
  if (total.load() > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::too_large,
                "extraction: " + what + ": " + std::to_string(total.load()) + " of them; expected fewer than 2^32");

  running_sum(lists.first);
  lists.values.resize(total.load());
  std::vector<std::uint32_t> next(lists.first);
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    visit(begin, end, [&](std::int64_t key, const Value& value) {
      lists.values[std::atomic_ref(next[key]).fetch_add(1, std::memory_order_relaxed)] = value;
    });
  });
  return lists;
}

}  // namespace isostrata
