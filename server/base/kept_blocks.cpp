#include "base/kept_blocks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <mutex>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace isostrata {
namespace {

// A sanitizer sees who uses what was freed only if it is freed.
#ifdef ISOSTRATA_SANITIZED
constexpr bool kKeeps = false;
#else
constexpr bool kKeeps = true;
#endif

/// Sizes that differ by less than an eighth are one, so that what is wanted next is likely to be there.
std::size_t rounded(std::size_t bytes) {
  const std::size_t step = std::max(kHugePage, std::bit_floor(bytes) / 8);
  return (bytes + step - 1) / step * step;
}

class KeptBlocks {
 public:
  void* take(std::size_t size) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = count_; i-- > 0;)
      if (blocks_[i].size == size) return remove(i);
    return nullptr;
  }
  void give(void* at, std::size_t size) noexcept {
    const std::lock_guard lock(mutex_);
    if (size > most_) return std::free(at);
    while (count_ == blocks_.size() || bytes_ + size > most_) std::free(remove(0));
    blocks_[count_++] = {at, size};
    bytes_ += size;
  }
  void keep_at_most(std::size_t bytes) noexcept {
    const std::lock_guard lock(mutex_);
    most_ = std::min(bytes, kMostKept);
    while (bytes_ > most_) std::free(remove(0));
  }
  void clear() noexcept {
    const std::lock_guard lock(mutex_);
    while (count_ > 0) std::free(remove(count_ - 1));
  }
  std::size_t bytes() {
    const std::lock_guard lock(mutex_);
    return bytes_;
  }

 private:
  struct Block {
    void* at = nullptr;
    std::size_t size = 0;
  };
  void* remove(std::size_t i) noexcept {
    void* const at = blocks_[i].at;
    bytes_ -= blocks_[i].size;
    std::move(blocks_.begin() + static_cast<std::ptrdiff_t>(i) + 1, blocks_.begin() + static_cast<std::ptrdiff_t>(count_),
              blocks_.begin() + static_cast<std::ptrdiff_t>(i));
    --count_;
    return at;
  }

  std::mutex mutex_;
  std::array<Block, 64> blocks_{};  // the oldest first
  std::size_t count_ = 0, bytes_ = 0, most_ = kMostKept;
};

/// Never destroyed: arrays of static life may end after anything else.
KeptBlocks& kept() {
  static auto* const blocks = new KeptBlocks;
  return *blocks;
}

}  // namespace

void* in_huge_pages(std::size_t bytes) noexcept {
  const std::size_t whole = (bytes + kHugePage - 1) / kHugePage * kHugePage;
  if (whole < bytes) return nullptr;
  void* const at = std::aligned_alloc(kHugePage, whole);
#if defined(__linux__)
  if (at) ::madvise(at, whole, MADV_HUGEPAGE);  // advice: if it is not taken, pages are small
#endif
  return at;
}

void* take_block(std::size_t bytes) {
  const std::size_t size = rounded(bytes);
  if constexpr (kKeeps)
    if (void* const at = kept().take(size)) return at;
  void* at = in_huge_pages(size);
  if (!at) {
    free_kept_blocks();
    at = in_huge_pages(size);
  }
  if (!at) throw std::bad_alloc();
  return at;
}

void give_block(void* at, std::size_t bytes) noexcept {
  if constexpr (kKeeps)
    kept().give(at, rounded(bytes));
  else
    std::free(at);
}

void keep_at_most(std::size_t bytes) noexcept { kept().keep_at_most(bytes); }
std::size_t kept_bytes() { return kept().bytes(); }
void free_kept_blocks() noexcept { kept().clear(); }

}  // namespace isostrata
