// A hash table that many threads fill at once, for numbering what they share.
#pragma once

#include <atomic>
#include <cstdint>

#include "base/buffer.h"
#include "base/parallel.h"

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

  /// slots: a power of two up to 2^31. bounded: insert() may give up.
  PointTable(std::uint32_t slots, bool bounded) : entries_(slots), mask_(slots - 1), bounded_(bounded) {
    parallel_for(slots, 1 << 16, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) entries_[i] = {};
    });
  }
  static std::uint64_t bytes(std::uint64_t slots) { return slots * sizeof(Entry); }

  /// The slot of the key, which is not kEmpty; kFull where the table is bounded and crowded. Any thread. Expected O(1).
  std::uint32_t insert(std::uint64_t key, std::uint64_t neighbourhood, std::uint32_t use) {
    const std::uint64_t hash = mix(key);
    std::uint64_t at = mix(neighbourhood) + (hash & (kWindow - 1));
    for (int probe = 0;; ++probe, ++at) {
      if (probe == kWindowProbes) at = hash >> 10;
      at &= mask_;
      Entry& entry = entries_[at];
      std::uint64_t found = std::atomic_ref(entry.key).load(std::memory_order_relaxed);
      if (found == kEmpty && std::atomic_ref(entry.key).compare_exchange_strong(found, key, std::memory_order_relaxed))
        found = key;
      if (found == key) {
        std::uint32_t first = std::atomic_ref(entry.first).load(std::memory_order_relaxed);
        while (use < first && !std::atomic_ref(entry.first).compare_exchange_weak(first, use, std::memory_order_relaxed)) {
        }
        return static_cast<std::uint32_t>(at);
      }
      if (bounded_ && probe > kMaxProbes) return kFull;
    }
  }

  /// Of a slot that insert() gave. Not while keys are inserted.
  std::uint64_t key(std::uint32_t slot) const { return entries_[slot].key; }
  std::uint32_t first_use(std::uint32_t slot) const { return entries_[slot].first; }
  std::uint32_t number(std::uint32_t slot) const { return entries_[slot].number; }
  void set_number(std::uint32_t slot, std::uint32_t number) { entries_[slot].number = number; }

 private:
  struct Entry {
    std::uint64_t key = kEmpty;
    std::uint32_t first = ~std::uint32_t{0};
    std::uint32_t number = 0;
  };
  static constexpr std::uint64_t kWindow = 1024;
  static constexpr int kWindowProbes = 16;
  static constexpr int kMaxProbes = 256;

  /// The finaliser of G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", 2014.
  static std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

  Buffer<Entry> entries_;
  std::uint64_t mask_;
  bool bounded_;
};

}  // namespace isostrata
