#include "import/bytes/xml_coding.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <limits>
#include <memory>

#include "base/parallel.h"
#include "import/bytes/unpack_bytes.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kMostUnpacked = 1100;      // of a packed byte: zlib's best is 1032, LZ4's 255
constexpr std::size_t kPart = std::size_t{3} << 16;  // bytes of base64 that are decoded together
constexpr std::uint8_t kNoByte = 64;

constexpr std::array<std::uint8_t, 256> sextets() {
  std::array<std::uint8_t, 256> out{};
  out.fill(kNoByte);
  std::uint8_t next = 0;
  for (const char c : "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/")
    if (c) out[static_cast<unsigned char>(c)] = next++;
  return out;
}
constexpr auto kSextets = sextets();

/// How many bytes of text hold so many.
std::uint64_t length_of(std::uint64_t bytes, bool base64) { return base64 ? (bytes + 2) / 3 * 4 : bytes; }

/// Four letters, of which the last ones may be '='. How many bytes they are; 0 if they are none.
std::size_t decode_quad(const std::byte* letters, std::uint8_t* to) {
  std::array<std::uint8_t, 4> of;
  for (std::size_t i = 0; i < 4; ++i) of[i] = kSextets[static_cast<unsigned char>(letters[i])];
  std::size_t bytes = 3;
  if ((of[0] | of[1] | of[2] | of[3]) >= kNoByte) [[unlikely]] {
    for (std::size_t last = 3; last >= 2 && letters[last] == std::byte{'='}; --last) of[last] = 0, --bytes;
    if ((of[0] | of[1] | of[2] | of[3]) >= kNoByte) return 0;
  }
  to[0] = static_cast<std::uint8_t>(of[0] << 2 | of[1] >> 4);
  to[1] = static_cast<std::uint8_t>(of[1] << 4 | of[2] >> 2);
  to[2] = static_cast<std::uint8_t>(of[2] << 6 | of[3]);
  return bytes;
}

/// Bytes [at, at + count) of a text that begins at its beginning, decoded into `room` if they have to be. Nothing if they are not there.
std::optional<std::span<const std::byte>> bytes_of(std::span<const std::byte> text, bool base64, std::uint64_t at, std::uint64_t count, std::vector<std::byte>& room) {
  if (!base64) {
    if (at > text.size() || count > text.size() - at) return std::nullopt;
    return text.subspan(at, count);
  }
  const std::uint64_t first = at / 3, end = (at + count + 2) / 3;
  if (end > text.size() / 4) return std::nullopt;
  room.resize(static_cast<std::size_t>(end - first) * 3);
  auto* const out = reinterpret_cast<std::uint8_t*>(room.data());
  const std::byte* letters = text.data() + first * 4;
  for (std::uint64_t quad = first; quad < end; ++quad, letters += 4) {
    const std::uint64_t wanted = std::min<std::uint64_t>(at + count - quad * 3, 3);
    if (decode_quad(letters, out + (quad - first) * 3) < wanted) return std::nullopt;
  }
  return std::span<const std::byte>(room).subspan(at % 3, count);
}

std::uint64_t number_at(std::span<const std::byte> numbers, std::size_t index, const XmlCoding& coding) {
  std::uint64_t out = 0;
  const std::size_t width = coding.wide ? 8 : 4;
  std::memcpy(&out, numbers.data() + index * width, width);
  return coding.swapped ? __builtin_bswap64(out) >> (64 - 8 * width) : out;
}

/// decode, of blocks.
bool unpack(const CodedValues& values, std::span<std::byte> to) {
  const auto packed = values.text.subspan(values.front);
  std::atomic<bool> good = true;
  parallel_for(static_cast<std::int64_t>(values.block_ends.size()), 4, [&](std::int64_t begin, std::int64_t end) {
    const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> inflate(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
    std::vector<std::byte> room;
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end) && good; ++i) {
      const std::uint64_t from = i == 0 ? 0 : values.block_ends[i - 1];
      const auto in = bytes_of(packed, values.coding.base64, from, values.block_ends[i] - from, room);
      const auto out = to.subspan(i * values.block_bytes, std::min(values.block_bytes, to.size() - i * values.block_bytes));
      bool done = in.has_value();
      if (done && values.coding.packing == Packing::zlib)
        done = inflate && libdeflate_zlib_decompress(inflate.get(), in->data(), in->size(), out.data(), out.size(), nullptr) == LIBDEFLATE_SUCCESS;
      else if (done)
        done = unpack_lz4_block(*in, out) == out.size();
      if (!done) good = false;
    }
  });
  return good;
}

}  // namespace

std::optional<CodedValues> coded_values(std::span<const std::byte> from, const XmlCoding& coding) {
  const std::size_t width = coding.wide ? 8 : 4;
  std::vector<std::byte> room;
  CodedValues out{.coding = coding, .text = {}, .front = 0, .bytes = 0, .block_bytes = 0, .block_ends = {}};
  if (coding.packing == Packing::none) {
    const auto length = bytes_of(from, coding.base64, 0, width, room);
    if (!length) return std::nullopt;
    out.bytes = number_at(*length, 0, coding);
    if (out.bytes > from.size()) return std::nullopt;
    const std::uint64_t all = length_of(width + out.bytes, coding.base64);
    if (all > from.size()) return std::nullopt;
    out.text = from.first(static_cast<std::size_t>(all));
    out.front = coding.base64 ? 0 : width;  // in base64 one text with the values
    return out;
  }
  const auto beginning = bytes_of(from, coding.base64, 0, 3 * width, room);
  if (!beginning) return std::nullopt;
  const std::uint64_t count = number_at(*beginning, 0, coding), last = number_at(*beginning, 2, coding);
  out.block_bytes = number_at(*beginning, 1, coding);
  if (count > from.size() / width || out.block_bytes == 0 || out.block_bytes > std::numeric_limits<int>::max() || last > out.block_bytes) return std::nullopt;
  const std::uint64_t numbers = (3 + count) * width;
  out.front = static_cast<std::size_t>(length_of(numbers, coding.base64));
  const auto all_numbers = bytes_of(from, coding.base64, 0, numbers, room);
  if (!all_numbers) return std::nullopt;
  std::uint64_t end = 0;
  out.block_ends.reserve(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t packed = number_at(*all_numbers, 3 + i, coding);
    if (packed > from.size() || (end += packed) > from.size()) return std::nullopt;
    out.block_ends.push_back(end);
  }
  const std::uint64_t text = length_of(end, coding.base64);
  if (text > from.size() - out.front || (count > 0 && (count - 1) > end)) return std::nullopt;
  if (count > 0 && (__builtin_mul_overflow(count - 1, out.block_bytes, &out.bytes) || __builtin_add_overflow(out.bytes, last > 0 ? last : out.block_bytes, &out.bytes)))
    return std::nullopt;
  if (out.bytes / kMostUnpacked > end) return std::nullopt;
  out.text = from.first(out.front + static_cast<std::size_t>(text));
  return out;
}

bool decode(const CodedValues& values, std::span<std::byte> to) {
  if (values.coding.packing != Packing::none) return unpack(values, to);
  if (!values.coding.base64) {
    std::memcpy(to.data(), values.as_they_lie().data(), to.size());
    return true;
  }
  const std::uint64_t skipped = values.coding.wide ? 8 : 4;  // the length
  std::atomic<bool> good = true;
  parallel_for(static_cast<std::int64_t>((to.size() + kPart - 1) / kPart), 1, [&](std::int64_t begin, std::int64_t end) {
    std::vector<std::byte> room;
    for (auto part = static_cast<std::size_t>(begin); part < static_cast<std::size_t>(end) && good; ++part) {
      const auto out = to.subspan(part * kPart, std::min(kPart, to.size() - part * kPart));
      const auto in = bytes_of(values.text, true, skipped + part * kPart, out.size(), room);
      if (in)
        std::memcpy(out.data(), in->data(), out.size());
      else
        good = false;
    }
  });
  return good;
}

}  // namespace isostrata
