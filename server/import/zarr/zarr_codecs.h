// How the chunks of a Zarr array are packed, and unpacking them.
#pragma once

#include <boost/json/value.hpp>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace isostrata {

/// The names are those of Zarr's registry of codecs; gzip reads zlib's streams as well. Shuffle puts the first bytes of all values first, then the second ones.
struct ZarrCodec {
  enum class Kind : std::uint8_t { blosc, zstd, gzip, lz4, bz2, crc32c, shuffle };
  Kind kind = Kind::blosc;
  std::size_t element = 1;  // of shuffle: the bytes of a value

  /// Whether what it makes has another size, which only unpacking tells.
  bool packs() const { return kind != Kind::crc32c && kind != Kind::shuffle; }
};

/// With its settings, also by the name that Zarr 3 gives to numcodecs' ("numcodecs.zlib"). Throws unsupported for a codec that is none of these, bad_data for settings
/// that make no sense. `file` is whose metadata names it.
ZarrCodec zarr_codec(const std::string& id, const boost::json::object& settings, const std::string& file);

/// Unpacks a chunk of `size` bytes, which `codecs` packed in their order. `stored` is what its file holds, and may be changed; the result has exactly `size` bytes and lies in
/// `stored` or in `out`, whose storage is reused; at most one of the codecs packs. Throws bad_data if the chunk is damaged, or has another size: it never takes more memory than `size` and the sums.
std::span<std::byte> decode_chunk(std::span<const ZarrCodec> codecs, std::vector<std::byte>& stored, std::size_t size, std::vector<std::byte>& out,
                                  const std::string& file);

}  // namespace isostrata
