#include "session/pacing/moving_format.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "engine/messages/coarse_levels.h"

namespace isostrata {
namespace {

constexpr std::array<double, 6> kScales{1, 0.8, 0.65, 0.5, 0.4, 0.3};  // of each side, that the machines' speed may ask for

}  // namespace

void MovingFormat::set_codecs(std::vector<Codec> codecs, bool chooses) {
  codecs_ = std::move(codecs);
  chooses_ = chooses;
}

void MovingFormat::step_down() {
  if (codecs_.size() > 1) codecs_.erase(codecs_.begin());
}

void MovingFormat::sent(const FrameOrder& order, std::uint64_t frame, double size) {
  if (order.key) return;  // the first of a stream: a decoder has to be made, too
  sent_.push_back({frame, order.codec, size});
  if (sent_.size() > kMostSent) sent_.pop_front();
}

void MovingFormat::decoded(std::uint64_t frame, double ms, TimePoint now) {
  const auto of = std::ranges::find_if(sent_, [&](const Sent& s) { return s.frame == frame; });
  if (of == sent_.end() || !(ms > 0) || ms > kMostDecodingMs) return;
  decoding_.measured(of->codec, ms / coding_weight(of->size), now);
  sent_.erase(sent_.begin(), of + 1);
}

void MovingFormat::choose_points(bool rests, double whole, double per_jpeg, const MakingCosts& costs, TimePoint now) {
  const double least = whole * CoarseChoice::kLeastScale * CoarseChoice::kLeastScale;
  const double decoded = decoding_.expected(Codec::jpeg, now);
  std::array<double, 1 + kCoarseLevels> turning{}, moving{};
  for (int level = 0; level <= kCoarseLevels; ++level) {
    const auto at = static_cast<std::size_t>(level);
    const double drawing = costs.drawing_ms(level, Codec::jpeg, least, now);
    turning[at] = drawing + coding_weight(least) * (per_jpeg + (decoded > 0 ? decoded : kFirstDecodingMs));
    moving[at] = turning[at] + costs.extraction_ms(level, drawing);
  }
  turned_coarse_.choose(std::span(turning).first<2>(), rests, now);  // what is made in advance is of the first level
  moved_coarse_.choose(moving, rests, now);
}

// JPEG, which everybody takes, or the best video; no other one, since what comes after it has halved chroma.
bool MovingFormat::choose(const FrameScheduler& frames, const MakingCosts& costs, const Others& others, TimePoint now) {
  chosen_at_ = now;
  std::vector<Codec> codecs{Codec::jpeg};
  const double jpeg_ms = costs.encoding_ms(Codec::jpeg, now);
  if (jpeg_ms > 0 && is_video(codecs_.front())) codecs.push_back(codecs_.front());
  const double whole = megapixels(frames.width(), frames.height());
  if (!(whole > 0) || costs.drawing_ms(0, Codec::jpeg, whole, now) <= 0) return false;

  const double per_jpeg = jpeg_ms > 0 ? jpeg_ms : MakingCosts::kFirstEncodingMs;
  choose_points(!frames.moving(), whole, per_jpeg, costs, now);
  const int level = costs.coarse_at_hand() ? coarse_level(costs.moves_layers()) : 0;

  std::vector<CodecCandidate> candidates;
  for (const Codec codec : codecs)
    for (const double scale : kScales) {
      const FrameScheduler::Passing passing = frames.passing(codec, scale, now);
      const double size = whole * passing.scale * passing.scale;
      const double drawing = costs.drawing_ms(level, codec, size, now);
      const double extraction = costs.moves_layers() ? costs.extraction_ms(level, drawing) : 0;
      const double per_encoding = jpeg_ms > 0 ? costs.encoding_ms(codec, now) : per_jpeg;
      const double per_decoding = decoding_.expected(codec, now);
      const double encoding = coding_weight(size) * per_encoding,
                   decoding = coding_weight(size) * (per_decoding > 0 ? per_decoding : kFirstDecodingMs);
      CodecCandidate candidate;
      candidate.codec = codec;
      candidate.scale = scale;
      candidate.making_ms = extraction + drawing + encoding + decoding;
      if (others.all > 0 && others.with[is_video(codec)] == 0) candidate.making_ms += drawing;
      // A change waits for the frame under way: as long as the slowest of the places takes that hold one frame at a time.
      const double wait = std::max({extraction, drawing + encoding, passing.line_ms, decoding});
      candidate.passing_ms = wait + passing.round_trip_ms + passing.line_ms;
      candidate.line_ms = passing.line_ms;
      candidate.likeness = passing.scale * passing.scale * passing.quality / 90;
      candidates.push_back(candidate);
    }
  const Codec before = choice_.codec();
  const std::size_t chosen = frames.moving() ? choice_.choose(candidates, now) : choice_.choose_anew(candidates, now);
  forecasts_.clear();
  for (const CodecCandidate& of : candidates) {
    if (of.scale != candidates[chosen].scale) continue;
    const double scale = frames.passing(of.codec, of.scale, now).scale;
    forecasts_.push_back({of.codec, of.ms(), static_cast<int>(std::lround(frames.width() * scale)),
                          static_cast<int>(std::lround(frames.height() * scale))});
  }
  return choice_.codec() != before;
}

}  // namespace isostrata
