// Many lists of which only the sum of sizes is large, in few pieces of memory.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "base/buffer.h"

namespace isostrata {

/// Keeps copies of lists that threads have filled in memory of their own, which stays in the cache. The pieces grow up to huge
/// pages: as one std::vector each, the lists of an extraction spent more time in page faults than in being filled.
template <class T>
class ListPool {
 public:
  /// Valid as long as the pool. Any thread.
  std::span<T> keep(std::span<const T> list) {
    if (list.empty()) return {};
    T* to;
    {
      std::lock_guard lock(mutex_);
      if (free_.size() < list.size()) {
        piece_bytes_ = std::min(kLargestPiece, piece_bytes_ * 2);
        pieces_.emplace_back(std::max(list.size(), piece_bytes_ / sizeof(T)));
        free_ = pieces_.back();
      }
      to = free_.data();
      free_ = free_.subspan(list.size());
    }
    std::copy(list.begin(), list.end(), to);
    return {to, list.size()};
  }
  /// Not while others keep lists.
  void clear() {
    pieces_ = {};
    free_ = {};
    piece_bytes_ = kSmallestPiece;
  }

 private:
  static constexpr std::size_t kSmallestPiece = 32 << 10, kLargestPiece = 4 << 20;
  std::mutex mutex_;  // guards what follows
  std::vector<Buffer<T>> pieces_;
  std::span<T> free_;  // of the last piece
  std::size_t piece_bytes_ = kSmallestPiece;
};

}  // namespace isostrata
