// Numbers of the other byte order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace isostrata {

/// Turns the bytes of each number of 2, 4 or 8 bytes over, at any address; numbers of 1 byte stay. What is left behind the last whole one stays, too.
inline void swap_bytes(std::span<std::byte> bytes, std::size_t width) {
  const auto swap = [bytes](auto word, const auto& turned) {
    for (std::size_t at = 0; at + sizeof word <= bytes.size(); at += sizeof word) {
      std::memcpy(&word, bytes.data() + at, sizeof word);
      word = turned(word);
      std::memcpy(bytes.data() + at, &word, sizeof word);
    }
  };
  if (width == 2) swap(std::uint16_t{}, [](std::uint16_t word) { return __builtin_bswap16(word); });
  if (width == 4) swap(std::uint32_t{}, [](std::uint32_t word) { return __builtin_bswap32(word); });
  if (width == 8) swap(std::uint64_t{}, [](std::uint64_t word) { return __builtin_bswap64(word); });
}

}  // namespace isostrata
