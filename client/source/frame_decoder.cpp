#include <algorithm>
#include <cstddef>
#include <cstring>

#include "bad_image.h"
#include "isostrata/frames.h"

namespace isostrata::client {
struct FrameDecoder::Parts {
  VideoDecoders video;
  std::unique_ptr<VideoDecoder> decoder;
  std::uint64_t stream = 0;  // that `decoder` is of
  bool needs_stream = false;

  // The picture that bands are put into: those of one revision and size, from the top.
  Picture bands;
  std::uint64_t revision = 0;
  std::uint32_t next_band = 0, next_row = 0;

  std::optional<Picture> band(const v1::Frame& frame);
};

// What is interrupted is never completed: the bands of another picture begin with index 0.
std::optional<Picture> FrameDecoder::Parts::band(const v1::Frame& frame) {
  const v1::Band& band = frame.band();
  if (band.index() == 0) {
    if (!is_picture_size(frame.width(), frame.height()))
      bad_image("a picture of " + std::to_string(frame.width()) + "x" + std::to_string(frame.height()) + " pixels in bands");
    bands = {static_cast<int>(frame.width()), static_cast<int>(frame.height()), {}};
    bands.rgb.resize(std::size_t{frame.width()} * frame.height() * 3);
    revision = frame.revision();
    next_band = next_row = 0;
  } else if (band.index() != next_band || frame.revision() != revision) {
    return std::nullopt;
  }
  const Picture part = client::decode(frame.payload());
  if (part.width != bands.width || static_cast<std::uint32_t>(part.height) != band.rows() || band.first_row() != next_row ||
      next_row + band.rows() > static_cast<std::uint32_t>(bands.height))
    bad_image("a band of " + std::to_string(part.width) + "x" + std::to_string(part.height) + " pixels does not fit into " +
           std::to_string(bands.width) + "x" + std::to_string(bands.height) + " at row " + std::to_string(band.first_row()));
  std::copy(part.rgb.begin(), part.rgb.end(), bands.rgb.begin() + static_cast<std::ptrdiff_t>(next_row) * bands.width * 3);
  next_row += band.rows();
  if (++next_band < band.count()) return std::nullopt;
  if (next_row != static_cast<std::uint32_t>(bands.height)) bad_image("the last band ends above the picture's last row");
  next_band = UINT32_MAX;  // whatever comes now begins anew
  return std::move(bands);
}

FrameDecoder::FrameDecoder(VideoDecoders video) : parts_(std::make_unique<Parts>()) { parts_->video = std::move(video); }
FrameDecoder::~FrameDecoder() = default;
FrameDecoder::FrameDecoder(FrameDecoder&&) noexcept = default;
FrameDecoder& FrameDecoder::operator=(FrameDecoder&&) noexcept = default;

bool FrameDecoder::needs_stream() const { return parts_->needs_stream; }

std::optional<Picture> FrameDecoder::decode(const v1::Frame& frame) {
  Parts& parts = *parts_;
  parts.needs_stream = false;
  if (frame.has_band()) return parts.band(frame);
  if (frame.stream_id() == 0) return client::decode(frame.payload());
  if (frame.stream_id() != parts.stream) {
    if (!frame.key()) {
      parts.needs_stream = true;
      return std::nullopt;
    }
    parts.decoder = parts.video ? parts.video(frame.format()) : nullptr;
    if (!parts.decoder) bad_image("a stream of " + frame.format() + ", of which there is no decoder here");
    parts.stream = frame.stream_id();
  }
  try {
    return parts.decoder->decode(frame.payload());
  } catch (...) {
    parts.decoder.reset();
    parts.stream = 0;
    parts.needs_stream = true;
    throw;
  }
}

}  // namespace isostrata::client
