#include "import/zarr/zarr_codecs.h"

#include <blosc.h>
#include <bzlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "base/error.h"
#include "import/bytes/unpack_bytes.h"
#include "import/zarr/zarr_json.h"

namespace isostrata {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kWord = 4;  // of a sum, and of lz4's length
constexpr auto kMostInt = static_cast<std::size_t>(std::numeric_limits<int>::max());

std::uint32_t little_endian(Bytes bytes) {
  std::uint32_t word = 0;
  for (std::size_t b = 0; b < kWord; ++b) word |= std::to_integer<std::uint32_t>(bytes[b]) << (8 * b);
  return word;
}

/// Castagnoli's polynomial, reflected (RFC 3720, appendix B.4).
std::uint32_t crc32c(Bytes bytes) {
  static constexpr auto kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t n = 0; n < 256; ++n) {
      table[n] = n;
      for (int bit = 0; bit < 8; ++bit) table[n] = (table[n] >> 1) ^ (table[n] & 1 ? 0x82f63b78u : 0u);
    }
    return table;
  }();
  std::uint32_t crc = ~0u;
  for (const std::byte byte : bytes) crc = kTable[(crc ^ std::to_integer<std::uint32_t>(byte)) & 0xff] ^ (crc >> 8);
  return ~crc;
}

// As those of unpack_bytes.h.

std::size_t unpack_blosc(Bytes from, std::span<std::byte> to) {
  std::size_t size = 0;
  if (from.size() < BLOSC_MIN_HEADER_LENGTH || blosc_cbuffer_validate(from.data(), from.size(), &size) < 0 || size != to.size()) return to.size() + 1;
  const int made = blosc_decompress_ctx(from.data(), to.data(), to.size(), 1);
  return made < 0 ? to.size() + 1 : static_cast<std::size_t>(made);
}

std::size_t unpack_zstd(Bytes from, std::span<std::byte> to) {
  const std::size_t made = ZSTD_decompress(to.data(), to.size(), from.data(), from.size());
  return ZSTD_isError(made) ? to.size() + 1 : made;
}

/// numcodecs' form: the size, then one block.
std::size_t unpack_lz4(Bytes from, std::span<std::byte> to) {
  return from.size() < kWord || little_endian(from) != to.size() ? to.size() + 1 : unpack_lz4_block(from.subspan(kWord), to);
}

std::size_t unpack_bz2(Bytes from, std::span<std::byte> to) {
  auto made = static_cast<unsigned>(to.size());
  if (std::max(from.size(), to.size()) > kMostInt) return to.size() + 1;
  const int state = BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(to.data()), &made, reinterpret_cast<char*>(const_cast<std::byte*>(from.data())),
                                               static_cast<unsigned>(from.size()), 0, 0);
  return state == BZ_OK ? made : to.size() + 1;
}

void unshuffle(Bytes from, std::size_t element, std::span<std::byte> to) {
  const std::size_t count = from.size() / element;
  for (std::size_t b = 0; b < element; ++b)
    for (std::size_t i = 0; i < count; ++i) to[i * element + b] = from[b * count + i];
}

using CodecKind = ZarrCodec::Kind;

struct Unpacker {
  CodecKind kind;
  const char* id;
  std::size_t (*unpack)(Bytes, std::span<std::byte>);
};

constexpr Unpacker kUnpackers[] = {{CodecKind::blosc, "blosc", unpack_blosc}, {CodecKind::zstd, "zstd", unpack_zstd}, {CodecKind::gzip, "gzip", inflate_all},
                                   {CodecKind::gzip, "zlib", inflate_all},    {CodecKind::lz4, "lz4", unpack_lz4},    {CodecKind::bz2, "bz2", unpack_bz2}};

}  // namespace

ZarrCodec zarr_codec(const std::string& id, const boost::json::object& settings, const std::string& file) {
  constexpr std::string_view kPrefix = "numcodecs.";
  const std::string name = id.starts_with(kPrefix) ? id.substr(kPrefix.size()) : id;
  if (name == "crc32c" && name == id) return {CodecKind::crc32c};  // numcodecs' puts the sum first
  if (name == "shuffle") {
    const boost::json::value* element = member(settings, "elementsize");
    if (element && (!element->is_int64() || element->get_int64() < 1 || element->get_int64() > 256)) throw Error(ErrorCode::bad_data, file + ": 'elementsize' of the filter 'shuffle' is not 1 to 256");
    return {CodecKind::shuffle, element ? static_cast<std::size_t>(element->get_int64()) : 4};
  }
  for (const Unpacker& of : kUnpackers)
    if (name == of.id) return {of.kind};
  throw Error(ErrorCode::unsupported, file + ": its chunks are packed by '" + id.substr(0, 60) + "'; expected blosc, zstd, gzip, zlib, lz4, bz2 or none");
}

std::span<std::byte> decode_chunk(std::span<const ZarrCodec> codecs, std::vector<std::byte>& stored, std::size_t size, std::vector<std::byte>& out,
                                  const std::string& file) {
  std::span<std::byte> bytes = stored;
  std::vector<std::byte>*now = &stored, *next = &out;  // where the bytes lie, and where those of the next codec go
  for (std::size_t c = codecs.size(); c-- > 0;) {
    if (codecs[c].kind == CodecKind::crc32c) {
      if (bytes.size() < kWord || little_endian(bytes.last(kWord)) != crc32c(bytes.first(bytes.size() - kWord)))
        throw Error(ErrorCode::bad_data, file + ": is damaged: its sum (crc32c) is not that of its bytes");
      bytes = bytes.first(bytes.size() - kWord);
      continue;
    }
    const auto sums = std::count_if(codecs.begin(), codecs.begin() + static_cast<std::ptrdiff_t>(c), [](const ZarrCodec& one) { return one.kind == CodecKind::crc32c; });
    const std::size_t wanted = size + kWord * static_cast<std::size_t>(sums);
    next->resize(wanted);
    if (codecs[c].kind == CodecKind::shuffle) {
      if (bytes.size() != wanted || wanted % codecs[c].element != 0)
        throw Error(ErrorCode::bad_data, file + ": has " + std::to_string(bytes.size()) + " bytes for the filter 'shuffle'; expected " + std::to_string(wanted) + " in values of " +
                                             std::to_string(codecs[c].element));
      unshuffle(bytes, codecs[c].element, *next);
    } else {
      const Unpacker& of = *std::find_if(std::begin(kUnpackers), std::end(kUnpackers), [&](const Unpacker& one) { return one.kind == codecs[c].kind; });
      const std::size_t made = of.unpack(bytes, *next);
      if (made != wanted)
        throw Error(ErrorCode::bad_data, file + ": is damaged or cut off, or is another size: expected " + std::to_string(wanted) + " bytes packed by " + of.id +
                                             (made < wanted ? ", found " + std::to_string(made) : ""));
    }
    bytes = *next;
    std::swap(now, next);
  }
  if (bytes.size() != size) throw Error(ErrorCode::bad_data, file + ": has " + std::to_string(bytes.size()) + " bytes; expected " + std::to_string(size));
  return bytes;
}

}  // namespace isostrata
