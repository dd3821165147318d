// How values stand in VTK's XML files: as they lie in memory or in base64, packed in blocks or not. A length comes first; of packed values there are the
// number of blocks, what each but the last holds, what the last one holds if that is less, and what each takes, then all blocks. In base64 the numbers in
// front of blocks are a text of their own.
//
// VTK's reader unpacks one block after the other by zlib. Here blocks are unpacked on all threads, and by libdeflate, which takes half of the time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace isostrata {

enum class Packing { none, zlib, lz4 };

struct XmlCoding {
  Packing packing = Packing::none;
  bool base64 = false;
  bool wide = false;     // lengths have 8 bytes and not 4
  bool swapped = false;  // they are of the other byte order, as the values are
  bool operator==(const XmlCoding&) const = default;
};

/// Values where they stand. The file must outlive it.
struct CodedValues {
  XmlCoding coding;
  std::span<const std::byte> text;        // with the numbers in front
  std::size_t front = 0;                  // how much of it those are
  std::uint64_t bytes = 0;                // of the values
  std::uint64_t block_bytes = 0;          // that each block but the last one holds
  std::vector<std::uint64_t> block_ends;  // of the packed bytes

  /// As they lie in memory, at any address.
  bool plain() const { return coding.packing == Packing::none && !coding.base64 && !coding.swapped; }
  /// Precondition: neither packed nor in base64.
  std::span<const std::byte> as_they_lie() const { return text.subspan(front); }
};

/// What begins there and ends in `from`. Nothing if no values do, or more than so many bytes can hold.
std::optional<CodedValues> coded_values(std::span<const std::byte> from, const XmlCoding& coding);

/// All of the values in their own byte order, on the threads. Precondition: room for just these. False if they are damaged.
bool decode(const CodedValues& values, std::span<std::byte> to);

}  // namespace isostrata
