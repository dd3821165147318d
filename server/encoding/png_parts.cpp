#include "encoding/png_parts.h"

#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace isostrata {
namespace {

/// Sum of the differences' absolute values as signed bytes: the usual guess of which filter deflates better.
std::uint64_t cost(std::span<const std::uint8_t> row) {
  std::uint64_t sum = 0;
  for (const std::uint8_t v : row) sum += static_cast<std::uint64_t>(std::abs(static_cast<int>(static_cast<std::int8_t>(v))));
  return sum;
}

/// The filter byte and the filtered row: Sub (1) or Up (2).
void filter_row(std::span<const std::uint8_t> row, std::span<const std::uint8_t> above, std::size_t channels, std::uint8_t* out,
                std::vector<std::uint8_t>& scratch) {
  scratch.resize(row.size());
  for (std::size_t i = 0; i < row.size(); ++i) out[1 + i] = static_cast<std::uint8_t>(row[i] - above[i]);
  for (std::size_t i = 0; i < channels; ++i) scratch[i] = row[i];
  for (std::size_t i = channels; i < row.size(); ++i) scratch[i] = static_cast<std::uint8_t>(row[i] - row[i - channels]);
  out[0] = 2;
  if (cost(scratch) < cost({out + 1, row.size()})) {
    out[0] = 1;
    std::memcpy(out + 1, scratch.data(), row.size());
  }
}

}  // namespace

bool is_opaque(const Image& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    if (image.rgba[i] != 255) return false;
  return true;
}

void put_u32(std::uint8_t* out, std::uint32_t v) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(v >> (24 - 8 * i));
}

void put_chunk(Bytes& out, const char* type, std::span<const std::uint8_t> data) {
  const std::size_t at = out.size();
  out.resize(at + 12 + data.size());
  put_u32(&out[at], static_cast<std::uint32_t>(data.size()));
  std::memcpy(&out[at + 4], type, 4);
  if (!data.empty()) std::memcpy(&out[at + 8], data.data(), data.size());
  put_u32(&out[at + 8 + data.size()], static_cast<std::uint32_t>(crc32(0, &out[at + 4], static_cast<uInt>(4 + data.size()))));
}

void pack_row(const std::uint8_t* rgba, int width, int channels, std::uint8_t* out) {
  if (channels == 4) {
    std::memcpy(out, rgba, static_cast<std::size_t>(width) * 4);
    return;
  }
  for (int x = 0; x < width; ++x)
    for (int c = 0; c < 3; ++c) out[3 * x + c] = rgba[4 * x + c];
}

std::vector<std::uint8_t> filter_rows(const Image& image, int channels, int first_row, int rows,
                                      std::span<const std::uint8_t> above) {
  const std::size_t stride = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(channels);
  std::vector<std::uint8_t> filtered((stride + 1) * static_cast<std::size_t>(rows)), before(stride, 0), row(stride), scratch;
  if (!above.empty()) before.assign(above.begin(), above.end());
  for (int y = 0; y < rows; ++y) {
    pack_row(&image.rgba[static_cast<std::size_t>(first_row + y) * static_cast<std::size_t>(image.width) * 4], image.width,
             channels, row.data());
    filter_row(row, before, static_cast<std::size_t>(channels), &filtered[static_cast<std::size_t>(y) * (stride + 1)], scratch);
    std::swap(row, before);
  }
  return filtered;
}

Bytes begin_png(int width, int height, int channels) {
  Bytes out{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::array<std::uint8_t, 13> header{};
  put_u32(&header[0], static_cast<std::uint32_t>(width));
  put_u32(&header[4], static_cast<std::uint32_t>(height));
  header[8] = 8;                                                 // bits a channel
  header[9] = static_cast<std::uint8_t>(channels == 4 ? 6 : 2);  // RGBA, RGB
  put_chunk(out, "IHDR", header);
  put_chunk(out, "sRGB", std::array<std::uint8_t, 1>{0});
  return out;
}

}  // namespace isostrata
