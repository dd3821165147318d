// PNG (ISO/IEC 15948) by hand: bands of rows deflated at the same time and joined into one zlib stream. The
// bands are raw deflate, each ended by a full flush, so their bytes may be concatenated; the Adler-32 sums are combined (the
// method of Mark Adler's pigz).
#include <zlib.h>

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "encoding/check_image.h"
#include "encoding/encode_image.h"
#include "encoding/png_parts.h"
#include "encoding/png_stream.h"

namespace isostrata {
namespace {

constexpr std::size_t kBandBytes = 256 << 10;  // of filtered rows; the window starts anew in each, which costs about 1 % in size

struct Band {
  Bytes deflated;
  uLong adler = 1;
  std::size_t bytes = 0;
};

Bytes deflate_raw(std::span<const std::uint8_t> bytes) {
  z_stream stream{};
  if (deflateInit2(&stream, 1, Z_DEFLATED, -15, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw Error(ErrorCode::too_large, "PNG: no memory to deflate");
  Bytes out(deflateBound(&stream, static_cast<uLong>(bytes.size())) + 64);
  stream.next_in = const_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  const int state = deflate(&stream, Z_FULL_FLUSH);
  out.resize(stream.total_out);
  const bool complete = stream.avail_in == 0 && state == Z_OK;
  deflateEnd(&stream);
  if (!complete) throw Error(ErrorCode::internal, "PNG: deflate did not finish");
  return out;
}

Band make_band(const Image& image, int channels, int first_row, int rows, std::span<const std::uint8_t> before) {
  std::vector<std::uint8_t> above(before.begin(), before.end());
  if (first_row > 0) {
    above.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(channels));
    pack_row(&image.rgba[static_cast<std::size_t>(first_row - 1) * static_cast<std::size_t>(image.width) * 4], image.width,
             channels, above.data());
  }
  const std::vector<std::uint8_t> filtered = filter_rows(image, channels, first_row, rows, above);
  return {deflate_raw(filtered), adler32(1, filtered.data(), static_cast<uInt>(filtered.size())), filtered.size()};
}

/// Rows as parts of one zlib stream: its beginning if they are the first, its end if they are the last. `before`: the
/// packed row above them, if there is one; adler: the stream's sum so far.
std::vector<Bytes> deflate_rows(const Image& rows, int channels, std::span<const std::uint8_t> before, uLong& adler, bool first,
                                bool last) {
  const std::size_t row_bytes = static_cast<std::size_t>(rows.width) * static_cast<std::size_t>(channels) + 1;
  const int rows_per_band = static_cast<int>(std::max<std::size_t>(1, kBandBytes / row_bytes));
  const int bands = (rows.height + rows_per_band - 1) / rows_per_band;
  std::vector<Band> band(static_cast<std::size_t>(bands));
  parallel_for(bands, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      const int at = static_cast<int>(b) * rows_per_band;
      band[static_cast<std::size_t>(b)] = make_band(rows, channels, at, std::min(rows_per_band, rows.height - at), before);
    }
  });
  std::vector<Bytes> parts;
  for (std::size_t b = 0; b < band.size(); ++b) {
    Bytes data;
    if (first && b == 0) data = {0x78, 0x01};
    data.insert(data.end(), band[b].deflated.begin(), band[b].deflated.end());
    adler = adler32_combine(adler, band[b].adler, static_cast<z_off_t>(band[b].bytes));
    if (last && b + 1 == band.size()) {
      data.insert(data.end(), {0x03, 0x00});  // an empty last block ends the raw deflate data
      data.resize(data.size() + 4);
      put_u32(&data[data.size() - 4], static_cast<std::uint32_t>(adler));
    }
    parts.push_back(std::move(data));
  }
  return parts;
}

}  // namespace

PngStream::PngStream(int width, int height, bool alpha, PngAnimation animation)
    : width_(width),
      height_(height),
      channels_(alpha ? 4 : 3),
      animation_(animation),
      pictures_left_(animation.pictures),
      rows_left_(0),
      begun_(begin_png(width, height, channels_)) {
  if (animation.pictures == 1) return;
  std::array<std::uint8_t, 8> control{};
  put_u32(&control[0], static_cast<std::uint32_t>(animation.pictures));  // then 0: again and again
  put_chunk(begun_, "acTL", control);
}

// The chunks acTL, fcTL and fdAT of "Portable Network Graphics (PNG) Specification (Third Edition)", section 11.3.6.
void PngStream::begin_picture(Bytes& out) {
  --pictures_left_;
  rows_left_ = height_;
  adler_ = 1;
  before_.clear();
  if (animation_.pictures == 1) return;
  std::array<std::uint8_t, 26> control{};
  put_u32(&control[0], sequence_++);
  put_u32(&control[4], static_cast<std::uint32_t>(width_));
  put_u32(&control[8], static_cast<std::uint32_t>(height_));
  const auto hundredths = static_cast<std::uint32_t>(std::clamp(animation_.seconds * 100 + 0.5, 1.0, 65535.0));
  control[20] = static_cast<std::uint8_t>(hundredths >> 8), control[21] = static_cast<std::uint8_t>(hundredths);
  control[23] = 100;  // hundredths of a second; each picture then replaces the one before
  put_chunk(out, "fcTL", control);
}

Bytes PngStream::put(const Image& rows) {
  check_image(rows);
  const int left = rows_left_ > 0 || pictures_left_ == 0 ? rows_left_ : height_;
  if (rows.width != width_ || rows.height > left)
    throw Error(ErrorCode::internal, "PNG: " + std::to_string(rows.width) + "x" + std::to_string(rows.height) + " pixels came; " +
                                         std::to_string(width_) + "x" + std::to_string(left) + " were left");
  Bytes out = std::exchange(begun_, {});
  if (rows_left_ == 0) begin_picture(out);
  rows_left_ -= rows.height;
  for (Bytes& part : deflate_rows(rows, channels_, before_, adler_, before_.empty(), rows_left_ == 0)) {
    // The parts of one picture are together one zlib stream.
    if (sequence_ > 1) {
      part.insert(part.begin(), 4, 0);
      put_u32(part.data(), sequence_++);
    }
    put_chunk(out, sequence_ > 1 ? "fdAT" : "IDAT", part);
  }
  before_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(channels_));
  pack_row(&rows.rgba[rows.rgba.size() - 4 * static_cast<std::size_t>(width_)], width_, channels_, before_.data());
  if (rows_left_ == 0 && pictures_left_ == 0) put_chunk(out, "IEND", {});
  return out;
}

Bytes encode_png(const Image& image) {
  check_image(image);
  return PngStream(image.width, image.height, !is_opaque(image)).put(image);
}

}  // namespace isostrata
