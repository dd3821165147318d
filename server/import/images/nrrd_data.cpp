#include "import/images/nrrd_data.h"

#include <bzlib.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>

#include "base/error.h"
#include "base/hex_digit.h"
#include "import/bytes/swap_bytes.h"

namespace isostrata {
namespace {

constexpr std::size_t kStep = 1u << 20;
constexpr std::size_t kMostTrailing = 64u << 20;  // kept behind the data where a negative byte skip counts from the end

[[noreturn]] void refuse_short(const std::string& name, const NrrdHeader& header, std::size_t declared, std::size_t present) {
  std::string sizes;
  for (const NrrdAxis& axis : header.axes) sizes += (sizes.empty() ? "" : "x") + std::to_string(axis.size);
  throw Error(ErrorCode::bad_data, name + ": " + sizes + " " + to_string(header.type) + " declared, which is " +
                                       std::to_string(declared) + " bytes in this file; " + std::to_string(present) + " present");
}

/// Calls `more` to fill the next part of the output until it returns false or `most` bytes are there.
template <class More>
std::vector<std::byte> grow(std::size_t most, const More& more) {
  std::vector<std::byte> out;
  std::size_t used = 0;
  while (used < most) {
    if (used == out.size()) out.resize(std::min(most, std::max(kStep, 2 * out.size())));
    const std::size_t got = more(out.data() + used, out.size() - used);
    used += got;
    if (got == 0) break;
  }
  out.resize(used);
  return out;
}

std::vector<std::byte> inflate_gzip(std::span<const std::byte> in, std::size_t most, const std::string& name) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK)
    throw Error(ErrorCode::unavailable, "zlib cannot start");  // 32: gzip or zlib header
  struct End {
    z_stream* stream;
    ~End() { inflateEnd(stream); }
  } end{&stream};
  bool done = false;
  return grow(most, [&](std::byte* to, std::size_t room) -> std::size_t {
    stream.next_out = reinterpret_cast<Bytef*>(to);
    const auto given = static_cast<uInt>(std::min<std::size_t>(room, 1u << 30));
    stream.avail_out = given;
    while (stream.avail_out == given && !done) {
      const auto part = static_cast<uInt>(std::min<std::size_t>(in.size(), 1u << 30));
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(in.data()));
      stream.avail_in = part;
      const int status = inflate(&stream, Z_NO_FLUSH);
      in = in.subspan(part - stream.avail_in);
      if (status == Z_STREAM_END) {  // another member may follow
        done = in.size() < 2 || in[0] != std::byte{0x1f} || in[1] != std::byte{0x8b} || inflateReset(&stream) != Z_OK;
      } else if (status == Z_BUF_ERROR && in.empty()) {
        done = true;  // truncated: the caller counts what is there
      } else if (status != Z_OK) {
        throw Error(ErrorCode::bad_data,
                    name + ": its gzip data are damaged (" + (stream.msg ? stream.msg : "error " + std::to_string(status)) + ")");
      }
    }
    return given - stream.avail_out;
  });
}

std::vector<std::byte> decompress_bzip2(std::span<const std::byte> in, std::size_t most, const std::string& name) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw Error(ErrorCode::unavailable, "bzip2 cannot start");
  struct End {
    bz_stream* stream;
    ~End() { BZ2_bzDecompressEnd(stream); }
  } end{&stream};
  bool done = false;
  return grow(most, [&](std::byte* to, std::size_t room) -> std::size_t {
    stream.next_out = reinterpret_cast<char*>(to);
    const auto given = static_cast<unsigned>(std::min<std::size_t>(room, 1u << 30));
    stream.avail_out = given;
    while (stream.avail_out == given && !done) {
      const auto part = static_cast<unsigned>(std::min<std::size_t>(in.size(), 1u << 30));
      stream.next_in = reinterpret_cast<char*>(const_cast<std::byte*>(in.data()));
      stream.avail_in = part;
      const int status = BZ2_bzDecompress(&stream);
      in = in.subspan(part - stream.avail_in);
      if (status == BZ_STREAM_END) {
        done = true;
      } else if (status != BZ_OK) {
        throw Error(ErrorCode::bad_data, name + ": its bzip2 data are damaged (error " + std::to_string(status) + ")");
      } else if (in.empty() && stream.avail_out == given) {
        done = true;
      }
    }
    return given - stream.avail_out;
  });
}

std::vector<std::byte> decode_hex(std::span<const std::byte> in, std::size_t most, const std::string& name) {
  std::size_t at = 0;
  return grow(most, [&](std::byte* to, std::size_t room) {
    std::size_t made = 0;
    int digits = 0, value = 0;
    for (; at < in.size() && made < room; ++at) {
      const char c = std::to_integer<char>(in[at]);
      const int digit = hex_digit(c);
      if (digit < 0) {
        if (c != ' ' && c != '\n' && c != '\r' && c != '\t')
          throw Error(ErrorCode::bad_data, name + ": byte " + std::to_string(at) + " of its hex data is not a hex digit");
        continue;
      }
      value = 16 * value + digit;
      if (++digits == 2) {
        to[made++] = static_cast<std::byte>(value);
        digits = value = 0;
      }
    }
    return made;
  });
}

template <class T>
std::vector<std::byte> decode_text(std::span<const std::byte> in, std::size_t values, const std::string& name) {
  std::vector<T> out;
  const char* at = reinterpret_cast<const char*>(in.data());
  const char* const end = at + in.size();
  const auto separator = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == ','; };
  while (out.size() < values) {
    while (at != end && separator(*at)) ++at;
    if (at == end) break;
    const char* const stop = std::find_if(at, end, separator);
    if (*at == '+') ++at;
    T value{};
    const auto [parsed, error] = std::from_chars(at, stop, value);
    if (error != std::errc{} || parsed != stop)
      throw Error(ErrorCode::bad_data,
                  name + ": value " + std::to_string(out.size() + 1) + " of its text is not a number that fits the type");
    out.push_back(value);
    at = stop;
  }
  const auto bytes = std::as_bytes(std::span<const T>(out));
  return {bytes.begin(), bytes.end()};
}

std::vector<std::byte> decode_text(std::span<const std::byte> in, const NrrdHeader& header, std::size_t values,
                                   const std::string& name) {
  switch (header.type) {
    case ScalarType::int8:
      return decode_text<std::int8_t>(in, values, name);
    case ScalarType::uint8:
      return decode_text<std::uint8_t>(in, values, name);
    case ScalarType::int16:
      return decode_text<std::int16_t>(in, values, name);
    case ScalarType::uint16:
      return decode_text<std::uint16_t>(in, values, name);
    case ScalarType::int32:
      return decode_text<std::int32_t>(in, values, name);
    case ScalarType::uint32:
      return decode_text<std::uint32_t>(in, values, name);
    case ScalarType::int64:
      return decode_text<std::int64_t>(in, values, name);
    case ScalarType::uint64:
      return decode_text<std::uint64_t>(in, values, name);
    case ScalarType::float32:
      return decode_text<float>(in, values, name);
    case ScalarType::float64:
      break;
  }
  return decode_text<double>(in, values, name);
}

std::span<const std::byte> skip_lines(std::span<const std::byte> in, std::int64_t lines, const std::string& name) {
  for (std::int64_t line = 0; line < lines; ++line) {
    const auto newline = std::find(in.begin(), in.end(), std::byte{'\n'});
    if (newline == in.end())
      throw Error(ErrorCode::bad_data,
                  name + ": line skip " + std::to_string(lines) + ", but only " + std::to_string(line) + " lines are there");
    in = in.subspan(static_cast<std::size_t>(newline - in.begin()) + 1);
  }
  return in;
}

/// Where the values begin, after the header's byte skip.
std::size_t skip_bytes(std::size_t present, std::size_t needed, const NrrdHeader& header, const std::string& name, std::vector<std::string>& notes) {
  std::size_t from = 0;
  if (header.byte_skip >= 0) {
    from = static_cast<std::size_t>(header.byte_skip);
    if (from > present || present - from < needed)
      refuse_short(name, header, needed, present - std::min(from, present));
  } else {
    if (present < needed) refuse_short(name, header, needed, present);
    const auto behind = static_cast<std::uint64_t>(-(header.byte_skip + 1));
    from = present - needed;
    if (behind <= from)
      from -= static_cast<std::size_t>(behind);
    else
      notes.push_back("byte skip " + std::to_string(header.byte_skip) + " leaves too few bytes; the values are the file's last " +
                      std::to_string(needed));
  }
  return from;
}

}  // namespace

std::vector<std::byte> decode_nrrd(std::span<const std::byte> file, const NrrdHeader& header, std::int64_t values,
                                   const std::string& name, std::vector<std::string>& notes) {
  const std::size_t needed = static_cast<std::size_t>(values) * size_of(header.type);
  const auto in = skip_lines(file, header.line_skip, name);
  if (header.encoding == NrrdEncoding::text) {
    auto decoded = decode_text(in, header, static_cast<std::size_t>(values), name);
    if (decoded.size() != needed) refuse_short(name, header, needed, decoded.size());
    return decoded;
  }
  const std::size_t most = header.byte_skip < 0 ? needed + kMostTrailing : needed + static_cast<std::size_t>(header.byte_skip);
  std::vector<std::byte> unpacked;
  std::span<const std::byte> bytes = in;
  if (header.encoding != NrrdEncoding::raw) {
    unpacked = header.encoding == NrrdEncoding::gzip    ? inflate_gzip(in, most, name)
               : header.encoding == NrrdEncoding::bzip2 ? decompress_bzip2(in, most, name)
                                                        : decode_hex(in, most, name);
    bytes = unpacked;
  }
  const std::size_t from = skip_bytes(bytes.size(), needed, header, name, notes);
  std::vector<std::byte> out;
  if (from == 0 && bytes.size() == needed && !unpacked.empty())
    out = std::move(unpacked);
  else
    out.assign(bytes.begin() + static_cast<std::ptrdiff_t>(from), bytes.begin() + static_cast<std::ptrdiff_t>(from + needed));
  if (header.big_endian && size_of(header.type) > 1) swap_bytes(out, size_of(header.type));
  return out;
}

std::optional<std::span<const std::byte>> nrrd_in_place(std::span<const std::byte> file, const NrrdHeader& header, std::int64_t values,
                                                        const std::string& name, std::vector<std::string>& notes) {
  if (header.encoding != NrrdEncoding::raw || (header.big_endian && size_of(header.type) > 1)) return std::nullopt;
  const std::size_t needed = static_cast<std::size_t>(values) * size_of(header.type);
  const auto in = skip_lines(file, header.line_skip, name);
  return in.subspan(skip_bytes(in.size(), needed, header, name, notes), needed);
}

}  // namespace isostrata
