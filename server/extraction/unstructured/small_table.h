// Which key was met before, among some dozen: a hash table that is emptied thousands of times a millisecond.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace isostrata {

/// Values by 64-bit keys other than ~0, by open addressing. For one thread.
class SmallTable {
 public:
  static constexpr std::uint64_t kFree = ~std::uint64_t{0};
  struct Entry {
    std::uint64_t key;
    std::uint32_t value;
  };

  /// Forgets all and has room for `most` keys.
  void start(std::size_t most) {
    const std::size_t wanted = std::bit_ceil(2 * most + 1);
    if (wanted > room_.size()) room_.resize(wanted);
    entries_ = wanted;
    shift_ = 64 - std::countr_zero(wanted);
    std::fill_n(room_.begin(), wanted, Entry{kFree, 0});
  }
  /// The entry of a key. When its key is kFree it is new: write both.
  Entry& at(std::uint64_t key) {
    std::size_t place = key * 0x9e3779b97f4a7c15u >> shift_;  // D. Knuth's multiplicative hashing
    while (room_[place].key != kFree && room_[place].key != key) place = (place + 1) & (entries_ - 1);
    return room_[place];
  }
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::size_t i = 0; i < entries_; ++i)
      if (room_[i].key != kFree) visit(room_[i]);
  }

 private:
  std::vector<Entry> room_;
  std::size_t entries_ = 0;
  int shift_ = 63;
};

}  // namespace isostrata
