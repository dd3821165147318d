// Blocks of bytes that were packed by gzip, zlib or LZ4.
#pragma once

#include <cstddef>
#include <span>

namespace isostrata {

// Each gives how many bytes it made of `from` in `to`, or more than to.size() if it fails or there would be more.

/// gzip, also several files behind each other, or zlib.
std::size_t inflate_all(std::span<const std::byte> from, std::span<std::byte> to);
/// One block without a header.
std::size_t unpack_lz4_block(std::span<const std::byte> from, std::span<std::byte> to);

}  // namespace isostrata
