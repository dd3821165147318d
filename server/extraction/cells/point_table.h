// A hash table that many threads fill at once, for numbering what they share.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "base/buffer.h"
#include "base/task.h"

namespace isostrata {

/// Open addressing over 64-bit keys. Each entry keeps the smallest *use* that asked for it: uses are numbered in an order that
/// does not depend on threads, so neither does anything that is made from them.
///
/// Keys come with a *neighbourhood*, a number that keys in use at about the same time have in common: such keys lie within 16 KB,
/// which a core's first cache holds, and only where that window is full anywhere else. On meshes whose cells are in some spatial
/// order this halves the time of a table that is larger than the caches.
class PointTable {
 public:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};
  static constexpr std::uint32_t kFull = ~std::uint32_t{0};

  /// slots: a power of two up to 2^31. bounded: insert() may give up. Throws cancelled.
  PointTable(std::uint32_t slots, bool bounded, const Task& task);
  static std::uint64_t bytes(std::uint64_t slots) { return slots * (sizeof(std::uint64_t) + sizeof(std::uint32_t)); }

  /// Where the search for a key starts. The key is not kEmpty.
  struct Search {
    std::uint64_t key, at, elsewhere;
  };
  /// Has the memory brought near. Some twenty other keys' turns later insert() need not wait for it: in a table larger than the
  /// caches this halves the time. Any thread.
  Search begin(std::uint64_t key, std::uint64_t neighbourhood) const {
    const std::uint64_t hash = mix(key);
    const std::uint64_t at = (mix(neighbourhood) + (hash & (kWindow - 1))) & mask_;
    __builtin_prefetch(keys_.data() + at, 1);
    __builtin_prefetch(first_.data() + at, 1);
    return {key, at, hash >> 10};
  }
  /// The slot of the key; kFull where the table is bounded and crowded. Any thread. Expected O(1).
  std::uint32_t insert(Search search, std::uint32_t use) {
    for (int probe = 0;; ++probe, ++search.at) {
      if (probe == kWindowProbes) search.at = search.elsewhere;
      search.at &= mask_;
      const std::atomic_ref key(keys_[search.at]);
      std::uint64_t found = key.load(std::memory_order_relaxed);
      if (found == kEmpty && key.compare_exchange_strong(found, search.key, std::memory_order_relaxed)) found = search.key;
      if (found == search.key) {
        const std::atomic_ref smallest(first_[search.at]);
        std::uint32_t first = smallest.load(std::memory_order_relaxed);
        while (use < first && !smallest.compare_exchange_weak(first, use, std::memory_order_relaxed)) {
        }
        return static_cast<std::uint32_t>(search.at);
      }
      if (bounded_ && probe > kMaxProbes) return kFull;
    }
  }

  /// Numbers the keys by their first uses, all below `uses`, and returns them in that order. Call once, after all inserts.
  /// Walks the table and not the uses: what is read at random is then one bit for each use, which a cache holds. Throws
  /// cancelled.
  Buffer<std::uint64_t> number_keys(std::uint64_t uses, const Task& task);
  /// Of a slot that insert() gave, after number_keys().
  std::uint32_t number(std::uint32_t slot) const { return first_[slot]; }

 private:
  static constexpr std::uint64_t kWindow = 1024;
  static constexpr int kWindowProbes = 16;
  static constexpr int kMaxProbes = 256;

  /// The finaliser of G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", 2014.
  static std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

  Buffer<std::uint64_t> keys_;   // [slots]
  Buffer<std::uint32_t> first_;  // [slots] use, then number
  std::uint64_t mask_;
  bool bounded_;
};

/// Asks for keys, whose uses are numbered in succession, some at a time. One object per thread.
class PointRequests {
 public:
  /// slots: of all uses; [first_use...] are filled.
  PointRequests(PointTable& table, std::uint32_t* slots, std::uint32_t first_use)
      : table_(table), slots_(slots), next_(first_use) {}

  void add(std::uint64_t key, std::uint64_t neighbourhood) {
    if (waiting_ == kTogether) flush();
    searches_[waiting_++] = table_.begin(key, neighbourhood);
  }
  /// Call after the last, and wherever the slots are read.
  void flush() {
    for (std::uint32_t i = 0; i < waiting_; ++i, ++next_) {
      slots_[next_] = table_.insert(searches_[i], next_);
      full_ |= slots_[next_] == PointTable::kFull;
    }
    waiting_ = 0;
  }
  bool full() const { return full_; }

 private:
  static constexpr std::uint32_t kTogether = 32;
  PointTable& table_;
  std::uint32_t* slots_;
  std::uint32_t next_;
  std::uint32_t waiting_ = 0;
  bool full_ = false;
  std::array<PointTable::Search, kTogether> searches_;
};

}  // namespace isostrata
