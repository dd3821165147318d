// The parts of a WebM file, read element by element.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <string_view>
#include <vector>

namespace isostrata::testing {

// The elements of a Matroska file, all the way down, as (id, content).
struct WebmElement {
  std::uint32_t id;
  std::string_view content;
  std::size_t at;  // of the id, in the file
};
inline void walk(std::string_view file, std::size_t begin, std::size_t end, std::vector<WebmElement>& out) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(file.at(i)); };
  for (std::size_t at = begin; at < end;) {
    const auto start = at;
    const int id_bytes = std::countl_zero(byte(at)) + 1;
    std::uint32_t id = 0;
    for (int i = 0; i < id_bytes; ++i) id = id << 8 | byte(at++);
    const int size_bytes = std::countl_zero(byte(at)) + 1;
    std::uint64_t size = byte(at++) & (0xffu >> size_bytes);
    for (int i = 1; i < size_bytes; ++i) size = size << 8 | byte(at++);
    ASSERT_LE(at + size, end) << "element " << std::hex << id;
    out.push_back({id, file.substr(at, size), start});
    for (const std::uint32_t parent :
         {0x18538067u, 0x114D9B74u, 0x4DBBu, 0x1549A966u, 0x1654AE6Bu, 0xAEu, 0xE0u, 0x1F43B675u, 0x1C53BB6Bu, 0xBBu, 0xB7u})
      if (id == parent) walk(file, at, at + size, out);
    at += size;
  }
}
inline std::uint64_t number(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char c : bytes) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

struct WebmFrame {
  std::uint64_t time_ms = 0;
  bool key = false;
  std::string_view bytes;
};

/// Of one track, in their order.
inline std::vector<WebmFrame> frames_of(std::string_view file) {
  std::vector<WebmElement> elements;
  walk(file, 0, file.size(), elements);
  std::vector<WebmFrame> frames;
  std::uint64_t cluster = 0;
  for (const WebmElement& element : elements) {
    if (element.id == 0xE7) cluster = number(element.content);
    if (element.id == 0xA3) frames.push_back({cluster + number(element.content.substr(1, 2)), (element.content.at(3) & 0x80) != 0, element.content.substr(4)});
  }
  return frames;
}

}  // namespace isostrata::testing
