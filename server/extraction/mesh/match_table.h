// A hash table that fits a core's cache, for bringing together what has the same key within one part of many.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace isostrata {

/// Entry: has Key key() const, set_key(Key) and bool used() const, false at first and true once the caller of at() is done with
/// it. Key: has std::uint64_t hash() const and operator==. One object per thread; its memory stays from part to part.
template <class Entry>
class MatchTable {
 public:
  /// Forgets everything and makes room for about `keys` different ones; more are welcome.
  void start(std::size_t keys) {
    std::size_t size = 64;
    while (size < 2 * keys) size *= 2;
    entries_.assign(size, Entry{});
    count_ = 0;
  }
  /// The entry of the key; a new one is as Entry{} is but for its key. Valid until the next call.
  template <class Key>
  Entry& at(const Key& key) {
    if (4 * count_ >= 3 * entries_.size()) grow();
    Entry& entry = find(entries_, key);
    if (!entry.used()) {
      entry.set_key(key);
      ++count_;
    }
    return entry;
  }
  /// Unused ones among them.
  std::span<const Entry> entries() const { return entries_; }

 private:
  template <class Key>
  static Entry& find(std::vector<Entry>& entries, const Key& key) {
    for (std::size_t at = key.hash();; ++at) {
      Entry& entry = entries[at & (entries.size() - 1)];
      if (!entry.used() || entry.key() == key) return entry;
    }
  }
  void grow() {
    std::vector<Entry> larger(entries_.size() * 2);
    for (const Entry& entry : entries_)
      if (entry.used()) find(larger, entry.key()) = entry;
    entries_.swap(larger);
  }

  std::vector<Entry> entries_;  // a power of two
  std::size_t count_ = 0;
};

/// One step of mixing numbers into a hash; its low bits are good.
inline std::uint64_t mixed_hash(std::uint64_t hash, std::uint64_t number) {
  hash = (hash ^ number) * 0x9e3779b97f4a7c15u;
  return hash ^ (hash >> 32);
}

}  // namespace isostrata
