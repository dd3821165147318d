// JPEG (ITU-T T.81) in stripes, encoded at the same time and joined by restart markers: each stripe's scan begins anew there, so
// one after another they are one picture's scan.
#include <turbojpeg.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "encoding/check_image.h"
#include "encoding/encode_image.h"

namespace isostrata {
namespace {

constexpr int kBlock = 8;                    // with full chroma a minimum coded unit is one block of each component
constexpr int kStripeRows = 128;             // whatever the number of threads: the same picture gives the same bytes
constexpr int kMaxSide = 65500;              // the library's own limit
constexpr std::size_t kMaxInterval = 65535;  // of blocks between restart markers

constexpr std::uint8_t kStartOfFrame = 0xc0, kStartOfScan = 0xda, kEndOfImage = 0xd9, kRestartInterval = 0xdd, kRestart = 0xd0;

/// Rows as a JPEG file of their own, with the tables that every other stripe has, too.
Bytes encode_rows(const Image& image, int first_row, int rows, int quality) {
  const std::unique_ptr<void, int (*)(tjhandle)> compressor(tjInitCompress(), tjDestroy);
  if (!compressor) throw Error(ErrorCode::unavailable, std::string("JPEG: ") + tjGetErrorStr());
  // The buffer is ours and large enough for the worst case, so the library never allocates one (TJFLAG_NOREALLOC).
  Bytes out(tjBufSize(image.width, rows, TJSAMP_444));
  unsigned char* data = out.data();
  unsigned long size = static_cast<unsigned long>(out.size());
  const std::uint8_t* pixels = &image.rgba[static_cast<std::size_t>(first_row) * static_cast<std::size_t>(image.width) * 4];
  if (tjCompress2(compressor.get(), pixels, image.width, 0, rows, TJPF_RGBX, &data, &size, TJSAMP_444, quality,
                  TJFLAG_NOREALLOC) != 0)
    throw Error(ErrorCode::internal, std::string("JPEG: ") + tjGetErrorStr2(compressor.get()));
  out.resize(size);
  return out;
}

/// Where the marker segment begins; they follow each other from the start to the scan.
std::size_t find_segment(const Bytes& file, std::uint8_t marker) {
  for (std::size_t at = 2; at + 4 <= file.size() && file[at] == 0xff;) {
    if (file[at + 1] == marker) return at;
    at += 2 + (static_cast<std::size_t>(file[at + 2]) << 8 | file[at + 3]);
  }
  throw Error(ErrorCode::internal, "JPEG: the library's file has no segment " + std::to_string(marker));
}

std::size_t scan_of(const Bytes& file) {
  const std::size_t header = find_segment(file, kStartOfScan);
  return header + 2 + (static_cast<std::size_t>(file[header + 2]) << 8 | file[header + 3]);
}

void put(Bytes& out, std::initializer_list<std::size_t> bytes) {
  for (const std::size_t byte : bytes) out.push_back(static_cast<std::uint8_t>(byte));
}

Bytes join_stripes(const std::vector<Bytes>& stripes, int height, std::size_t interval) {
  const Bytes& first = stripes.front();
  const std::size_t scan_header = find_segment(first, kStartOfScan), frame = find_segment(first, kStartOfFrame);
  Bytes out(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(scan_header));
  out[frame + 5] = static_cast<std::uint8_t>(height >> 8), out[frame + 6] = static_cast<std::uint8_t>(height);
  put(out, {0xff, kRestartInterval, 0, 4, interval >> 8, interval & 255});
  out.insert(out.end(), first.begin() + static_cast<std::ptrdiff_t>(scan_header),
             first.begin() + static_cast<std::ptrdiff_t>(scan_of(first)));
  for (std::size_t i = 0; i < stripes.size(); ++i) {
    if (i > 0) put(out, {0xff, kRestart + (i - 1) % 8});
    out.insert(out.end(), stripes[i].begin() + static_cast<std::ptrdiff_t>(scan_of(stripes[i])), stripes[i].end() - 2);
  }
  put(out, {0xff, kEndOfImage});
  return out;
}

}  // namespace

Bytes encode_jpeg(const Image& image, int quality) {
  check_image(image);
  if (quality < 1 || quality > 100)
    throw Error(ErrorCode::invalid_argument, "JPEG quality " + std::to_string(quality) + ": expected 1 to 100");
  const std::size_t interval = static_cast<std::size_t>((image.width + kBlock - 1) / kBlock) * (kStripeRows / kBlock);
  const int count = (image.height + kStripeRows - 1) / kStripeRows;
  if (image.height > kMaxSide)  // the stripes by themselves would not notice
    throw Error(ErrorCode::too_large,
                "JPEG: " + std::to_string(image.height) + " rows; expected at most " + std::to_string(kMaxSide));
  if (count == 1 || interval > kMaxInterval) return encode_rows(image, 0, image.height, quality);
  std::vector<Bytes> stripes(static_cast<std::size_t>(count));
  parallel_for(count, 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<int>(begin); i < static_cast<int>(end); ++i)
      stripes[static_cast<std::size_t>(i)] =
          encode_rows(image, i * kStripeRows, std::min(kStripeRows, image.height - i * kStripeRows), quality);
  });
  return join_stripes(stripes, image.height, interval);
}

}  // namespace isostrata
