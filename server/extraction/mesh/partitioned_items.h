// Small items brought together by ranges of their keys, in parallel and without atomics: the first step of matching millions of
// faces by points. What lies in one part fits a core's cache, where a hash table is fast.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "base/parallel.h"
#include "base/task.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {

/// Ranges of keys: part p is [p << shift, (p + 1) << shift).
struct KeyRanges {
  int shift = 0;
  std::int64_t parts = 1;

  std::int64_t part(std::int64_t key) const { return key >> shift; }
  std::uint32_t width() const { return std::uint32_t{1} << shift; }
  /// So many of [0, keys) that about `items` make up parts of some thousand; none wider than 2^16.
  static KeyRanges of(std::int64_t keys, std::int64_t items) {
    constexpr std::int64_t kItemsPerPart = 1 << 11, kMaxParts = 1 << 13;
    const std::int64_t wanted = std::clamp<std::int64_t>(items / kItemsPerPart, 1, kMaxParts);
    KeyRanges ranges;
    while (keys >> ranges.shift >= 2 * wanted && ranges.shift < 16) ++ranges.shift;
    ranges.parts = ((std::max<std::int64_t>(keys, 1) - 1) >> ranges.shift) + 1;
    return ranges;
  }
};

/// Each part's items in the order in which they were visited.
template <class Item>
struct PartitionedItems {
  std::vector<std::uint64_t> first;  // [parts + 1] into items
  Buffer<Item> items;

  std::int64_t parts() const { return static_cast<std::int64_t>(first.size()) - 1; }
  std::span<const Item> of(std::int64_t part) const { return {items.data() + first[part], items.data() + first[part + 1]}; }
};

/// visit(begin, end, emit) calls emit(part, item) for what is in [begin, end) of [0, count); it is called twice for each of the
/// same blocks. O(count + items). Throws too_large (`what` says of what), cancelled.
template <class Item, class Visit>
PartitionedItems<Item> partition_items(std::int64_t parts, std::int64_t count, const std::string& what, std::uint64_t max_bytes,
                                       const Task& task, const Visit& visit) {
  constexpr std::int64_t kMaxBlocks = 256, kVisitsPerBlock = 1 << 14;
  PartitionedItems<Item> out;
  const std::int64_t block = std::max(kVisitsPerBlock, (count + kMaxBlocks - 1) / kMaxBlocks);
  const std::int64_t blocks = (count + block - 1) / block;
  check_budget(what, static_cast<std::uint64_t>(blocks * parts) * sizeof(std::uint64_t), max_bytes);

  std::vector<std::uint64_t> next(static_cast<std::size_t>(blocks * parts));  // [blocks][parts] counts, then where to write
  const auto each_block = [&](const auto& emit_of) {
    parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b) {
        const auto emit = emit_of(next.data() + b * parts);
        constexpr std::int64_t kVisitsPerCheck = 4096;
        for (std::int64_t at = b * block; at < std::min(count, (b + 1) * block); at += kVisitsPerCheck) {
          task.check();
          visit(at, std::min({count, (b + 1) * block, at + kVisitsPerCheck}), emit);
        }
      }
    });
  };
  each_block([&](std::uint64_t* counts) { return [counts](std::int64_t part, const Item&) { ++counts[part]; }; });
  std::uint64_t sum = 0;
  for (std::int64_t p = 0; p < parts; ++p) {
    out.first.push_back(sum);
    for (std::int64_t b = 0; b < blocks; ++b) {
      const std::uint64_t own = next[b * parts + p];
      next[b * parts + p] = sum;
      sum += own;
    }
  }
  out.first.push_back(sum);
  check_budget(what, sum * sizeof(Item) + next.size() * sizeof(std::uint64_t), max_bytes);
  out.items.resize(sum);
  each_block(
      [&](std::uint64_t* to) { return [&out, to](std::int64_t part, const Item& item) { out.items[to[part]++] = item; }; });
  return out;
}

}  // namespace isostrata
