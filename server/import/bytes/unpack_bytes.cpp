#include "import/bytes/unpack_bytes.h"

#include <lz4.h>
#include <zlib.h>

#include <algorithm>
#include <limits>

namespace isostrata {

std::size_t inflate_all(std::span<const std::byte> from, std::span<std::byte> to) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) return to.size() + 1;
  std::size_t read = 0, made = 0;
  int state = Z_OK;
  while (state == Z_OK) {
    const auto in = static_cast<uInt>(std::min(from.size() - read, std::size_t{1} << 30)), room = static_cast<uInt>(std::min(to.size() - made, std::size_t{1} << 30));
    std::byte beyond{};
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(from.data() + read));
    stream.avail_in = in;
    stream.next_out = reinterpret_cast<Bytef*>(room > 0 ? to.data() + made : &beyond);
    stream.avail_out = std::max(room, 1u);
    state = inflate(&stream, Z_NO_FLUSH);
    read += in - stream.avail_in;
    made += std::max(room, 1u) - stream.avail_out;
    if (made > to.size()) break;
    if (state == Z_STREAM_END && read < from.size() && from[read] == std::byte{0x1f}) state = inflateReset(&stream);  // files of gzip may follow each other
  }
  inflateEnd(&stream);
  return state == Z_STREAM_END ? made : to.size() + 1;
}

std::size_t unpack_lz4_block(std::span<const std::byte> from, std::span<std::byte> to) {
  if (std::max(from.size(), to.size()) > static_cast<std::size_t>(std::numeric_limits<int>::max())) return to.size() + 1;
  const int made = LZ4_decompress_safe(reinterpret_cast<const char*>(from.data()), reinterpret_cast<char*>(to.data()), static_cast<int>(from.size()), static_cast<int>(to.size()));
  return made < 0 ? to.size() + 1 : static_cast<std::size_t>(made);
}

}  // namespace isostrata
