// The pictures that servers send. PNG: W3C, "Portable Network Graphics (PNG) Specification", second edition, 2003.
#include <turbojpeg.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string_view>

#include "bad_image.h"
#include "isostrata/image.h"
#include "isostrata/options.h"

namespace isostrata::client {
namespace {

std::uint32_t big_endian(const unsigned char* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 | bytes[3];
}

void check_size(std::uint64_t width, std::uint64_t height) {
  if (!is_picture_size(width, height)) bad_image("a picture of " + std::to_string(width) + "x" + std::to_string(height) + " pixels");
}

Picture decode_jpeg(const std::string& bytes) {
  const auto close = [](void* handle) { tjDestroy(handle); };
  const std::unique_ptr<void, decltype(close)> handle(tjInitDecompress(), close);
  if (!handle) bad_image("no JPEG decoder");
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, subsampling = 0, colorspace = 0;
  if (tjDecompressHeader3(handle.get(), data, bytes.size(), &width, &height, &subsampling, &colorspace) != 0)
    bad_image(tjGetErrorStr2(handle.get()));
  check_size(static_cast<std::uint64_t>(std::max(width, 0)), static_cast<std::uint64_t>(std::max(height, 0)));
  Picture picture{width, height,
                  std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3)};
  if (tjDecompress2(handle.get(), data, bytes.size(), picture.rgb.data(), width, 0, height, TJPF_RGB, TJFLAG_ACCURATEDCT) != 0)
    bad_image(tjGetErrorStr2(handle.get()));
  return picture;
}

std::uint8_t paeth(int a, int b, int c) {  // section 9.4
  const int p = a + b - c;
  const int pa = std::abs(p - a), pb = std::abs(p - b), pc = std::abs(p - c);
  return static_cast<std::uint8_t>(pa <= pb && pa <= pc ? a : pb <= pc ? b : c);
}

// Undoes the row's filter in place; `above` is the row before, zeros for the first.
void unfilter(int filter, std::uint8_t* row, const std::uint8_t* above, std::size_t size, std::size_t pixel) {
  for (std::size_t i = 0; i < size; ++i) {
    const int left = i >= pixel ? row[i - pixel] : 0;
    const int up = above[i];
    const int corner = i >= pixel ? above[i - pixel] : 0;
    switch (filter) {
      case 0:
        return;
      case 1:
        row[i] = static_cast<std::uint8_t>(row[i] + left);
        break;
      case 2:
        row[i] = static_cast<std::uint8_t>(row[i] + up);
        break;
      case 3:
        row[i] = static_cast<std::uint8_t>(row[i] + (left + up) / 2);
        break;
      case 4:
        row[i] = static_cast<std::uint8_t>(row[i] + paeth(left, up, corner));
        break;
      default:
        bad_image("PNG: unknown filter " + std::to_string(filter));
    }
  }
}

Picture decode_png(const std::string& bytes) {
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  Picture picture;
  std::size_t channels = 0;
  std::string packed;
  bool ended = false;
  for (std::size_t at = 8; !ended;) {
    if (bytes.size() - at < 12) bad_image("PNG: truncated");
    const std::size_t size = big_endian(data + at);
    if (size > bytes.size() - at - 12) bad_image("PNG: truncated");
    const unsigned char* body = data + at + 8;
    if (big_endian(body + size) != crc32(0, data + at + 4, static_cast<uInt>(size + 4)))
      bad_image("PNG: a chunk's checksum is wrong");
    const std::string_view type(bytes.data() + at + 4, 4);
    if (type == "IHDR") {
      if (size != 13 || body[8] != 8 || (body[9] != 2 && body[9] != 6) || body[12] != 0)
        bad_image("PNG: not 8-bit RGB or RGBA without interlacing");
      check_size(big_endian(body), big_endian(body + 4));
      picture.width = static_cast<int>(big_endian(body));
      picture.height = static_cast<int>(big_endian(body + 4));
      channels = body[9] == 2 ? 3 : 4;
    } else if (type == "IDAT") {
      packed.append(reinterpret_cast<const char*>(body), size);
    } else if (type == "IEND") {
      ended = true;
    }
    at += size + 12;
  }
  if (channels == 0) bad_image("PNG: no header");

  const std::size_t width = static_cast<std::size_t>(picture.width), height = static_cast<std::size_t>(picture.height),
                    row = width * channels;
  std::vector<std::uint8_t> lines((row + 1) * height);
  uLongf unpacked = static_cast<uLongf>(lines.size());
  if (uncompress(lines.data(), &unpacked, reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size())) !=
          Z_OK ||
      unpacked != lines.size())
    bad_image("PNG: the compressed data is not a picture of " + std::to_string(width) + "x" + std::to_string(height));
  picture.rgb.resize(width * height * 3);
  const std::vector<std::uint8_t> zeros(row);
  const std::uint8_t* above = zeros.data();
  for (std::size_t y = 0; y < height; ++y) {
    std::uint8_t* line = lines.data() + y * (row + 1);
    unfilter(line[0], line + 1, above, row, channels);
    above = line + 1;
    for (std::size_t x = 0; x < width; ++x) std::memcpy(&picture.rgb[(y * width + x) * 3], line + 1 + x * channels, 3);
  }
  return picture;
}

}  // namespace

Picture decode(const std::string& bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return decode_png(bytes);
  if (bytes.starts_with("\xff\xd8")) return decode_jpeg(bytes);
  bad_image("neither PNG nor JPEG");
}

}  // namespace isostrata::client
