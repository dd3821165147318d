// Memory of large arrays that was freed and is soon wanted again: what the kernel has cleared once it need not clear again.
//
// An extraction makes arrays of tens of megabytes and frees those of the one before. Given back to the kernel, each page is cleared
// when it is next touched: a sixth to a third of the time of an interval that is dragged.
#pragma once

#include <cstddef>

namespace isostrata {

inline constexpr std::size_t kHugePage = std::size_t{2} << 20;
/// No more is kept than this, the newest, unless somebody says less.
inline constexpr std::size_t kMostKept = std::size_t{256} << 20;

/// At least so many bytes, aligned to huge pages, for which the kernel is asked; freed by std::free. Null if there are none. Any thread.
void* in_huge_pages(std::size_t bytes) noexcept;

/// As in_huge_pages, or what was given back. What is in them is anything. Throws std::bad_alloc.
/// bytes >= kHugePage. Any thread.
void* take_block(std::size_t bytes);
/// bytes: as it was taken. Any thread.
void give_block(void* at, std::size_t bytes) noexcept;

/// From now on no more is kept than this; at most kMostKept. Any thread.
void keep_at_most(std::size_t bytes) noexcept;
/// What is kept now, in bytes.
std::size_t kept_bytes();
/// Gives all of it back to the kernel.
void free_kept_blocks() noexcept;

}  // namespace isostrata
