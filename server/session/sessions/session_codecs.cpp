// Of a session: what its moving frames cost in each codec, and which codec and size each viewer gets them in.
#include <algorithm>
#include <cmath>

#include "engine/messages/coarse_levels.h"
#include "session/sessions/session.h"

namespace isostrata {
namespace {

constexpr double kMegapixel = 1e6;
constexpr std::size_t kMostSent = 64;                        // frames of a viewer whose decoding may still be told
constexpr Duration kChoose = std::chrono::milliseconds(40);  // between choices: costs do not change faster
constexpr std::array<double, 6> kScales{1, 0.8, 0.65, 0.5, 0.4, 0.3};  // of each side, that the machines' speed may ask for
constexpr double kMostDecodingMs = 10000;

// Until something is measured: of JPEG by weight().
constexpr double kFirstEncodingMs = 5, kFirstDecodingMs = 5;

constexpr double kLeastCoarsePart = 0.1;
constexpr double kMostRefiningMs = 2000;  // of drawing a picture that is there already once more, with more samples

/// Of what the first coarse level takes, what another one does: of finding its layers, which goes by cells, and of drawing them, by facets and by pixels.
double part_of_cells(int level) { return 1 / std::pow(kCoarser.at(static_cast<std::size_t>(level - 1)), 3); }
double part_of_drawing(int level) { return 0.5 + 0.5 / std::pow(kCoarser.at(static_cast<std::size_t>(level - 1)), 2); }
constexpr double kFirstPartOfCells = 0.125;  // of all points, that the first level has

double megapixels(double width, double height) { return width * height / kMegapixel; }
/// What encoding and decoding are in proportion to: pixels, and as much as a small picture has whatever its size.
double weight(double megapixels) { return 0.08 + megapixels; }

}  // namespace

int Session::coarse_level(const Viewer& viewer) const { return (costs_.extracts ? viewer.moved_coarse : viewer.turned_coarse).level(); }

void Session::note_made(const Picture& picture, const FrameReady& ready, TimePoint now) {
  const StageTimes& ms = ready.stages;
  const double drawing = ms.order_ms + ms.draw_ms + ms.readback_ms;
  const double size = megapixels(ready.width, ready.height);
  if (picture.request.still || picture.request.samples > 1) return;
  costs_.coarse_at_hand = ready.coarse_at_hand;
  const bool coarse = ready.point_stride > 1;
  const int level = std::max(1, picture.request.coarse);
  if (ms.extract_ms > 0 && coarse)
    costs_.coarse_extraction = ms.extract_ms / part_of_cells(level);
  else if (ms.extract_ms > 0)
    costs_.extraction = ms.extract_ms;
  if (picture.order.phase != FramePhase::moving || picture.request.lossless) {
    costs_.extracts = false;
    // What every n-th point took by what this takes holds for the next gesture, too.
    const double whole = costs_.drawing.ms(Codec::jpeg, size, now), coarse = costs_.coarse_drawing.ms(Codec::jpeg, size, now);
    if (costs_.coarse_drawing.pictures() >= CodecCosts::kEnough && whole > 0)
      costs_.coarse_part = std::clamp(coarse / whole, kLeastCoarsePart, 1.0);
    costs_.drawing.rested(drawing, size, now);
    costs_.coarse_drawing.rested(costs_.coarse_part * drawing, size, now);
    return;
  }
  const Codec codec = ready.video ? ready.video->codec : Codec::jpeg;
  if (coarse)
    costs_.coarse_drawing.moved(codec, drawing / part_of_drawing(level), size, now);
  else
    costs_.drawing.moved(codec, drawing, size, now);
  if (ready.video && ready.video->key) return;  // the first of a stream: an encoder had to be made, too
  costs_.encoding.measured(codec, ms.encode_ms / weight(size), now);
}

void Session::note_sent(Viewer& viewer, const FrameOrder& order, const FrameReady& ready, std::uint64_t frame) {
  if (order.key) return;  // the first of a stream: a decoder has to be made, too
  viewer.sent.push_back({frame, order.codec, megapixels(ready.width, ready.height)});
  if (viewer.sent.size() > kMostSent) viewer.sent.pop_front();
}

// What a client says may be anything.
void Session::note_decoded(Viewer& viewer, std::uint64_t frame, double ms, TimePoint now) {
  const auto of = std::find_if(viewer.sent.begin(), viewer.sent.end(), [&](const auto& s) { return s.frame == frame; });
  if (of == viewer.sent.end() || !(ms > 0) || ms > kMostDecodingMs) return;
  viewer.decoding.measured(of->codec, ms / weight(of->pixels), now);
  viewer.sent.erase(viewer.sent.begin(), of + 1);
}

// JPEG, which everybody takes, or the best video; no other one, since what comes after it has halved chroma.
void Session::choose_codec(Viewer& viewer, TimePoint now) {
  viewer.chosen_at = now;
  std::vector<Codec> codecs{Codec::jpeg};
  const double jpeg_ms = costs_.encoding.expected(Codec::jpeg, now);
  if (jpeg_ms > 0 && is_video(viewer.ladder.front())) codecs.push_back(viewer.ladder.front());
  const double whole = megapixels(viewer.frames.width(), viewer.frames.height());
  if (!(whole > 0) || costs_.drawing.ms(Codec::jpeg, whole, now) <= 0) return;

  // Another picture than those that the others look at is a drawing more, which all wait for.
  int others = 0;
  std::array<int, 2> with{};
  for (const auto& [key, other] : viewers_) {
    if (other == &viewer || !other->frames.visible() || other->frames.width() != viewer.frames.width() ||
        other->frames.height() != viewer.frames.height())
      continue;
    ++others;
    ++with[is_video(other->codec())];
  }

  const double per_jpeg = jpeg_ms > 0 ? jpeg_ms : kFirstEncodingMs, decoded = viewer.decoding.expected(Codec::jpeg, now);
  const double least = whole * CoarseChoice::kLeastScale * CoarseChoice::kLeastScale;
  const auto drawing_at = [&](int level, Codec codec, double pixels) {
    return level == 0 ? costs_.drawing.ms(codec, pixels, now) : part_of_drawing(level) * costs_.coarse_drawing.ms(codec, pixels, now);
  };
  const double first_extraction = costs_.coarse_extraction > 0 ? costs_.coarse_extraction : kFirstPartOfCells * costs_.extraction;
  const auto extraction_at = [&](int level) { return level == 0 ? costs_.extraction : part_of_cells(level) * first_extraction; };
  std::array<double, 1 + kCoarseLevels> turning{}, moving{};
  for (int level = 0; level <= kCoarseLevels; ++level) {
    const auto at = static_cast<std::size_t>(level);
    turning[at] = drawing_at(level, Codec::jpeg, least) + weight(least) * (per_jpeg + (decoded > 0 ? decoded : kFirstDecodingMs));
    moving[at] = turning[at] + extraction_at(level);
  }
  const bool rests = !viewer.frames.moving();
  viewer.turned_coarse.choose(std::span(turning).first<2>(), rests, now);  // what is made in advance is of the first level
  viewer.moved_coarse.choose(moving, rests, now);
  const int level = costs_.coarse_at_hand ? coarse_level(viewer) : 0;
  const double extraction = costs_.extracts ? extraction_at(level) : 0;

  std::vector<CodecCandidate> candidates;
  for (const Codec codec : codecs)
    for (const double scale : kScales) {
      const FrameScheduler::Passing passing = viewer.frames.passing(codec, scale, now);
      const double pixels = whole * passing.scale * passing.scale;
      const double drawing = drawing_at(level, codec, pixels);
      const double per_encoding = jpeg_ms > 0 ? costs_.encoding.expected(codec, now) : per_jpeg;
      const double per_decoding = viewer.decoding.expected(codec, now);
      const double encoding = weight(pixels) * per_encoding,
                   decoding = weight(pixels) * (per_decoding > 0 ? per_decoding : kFirstDecodingMs);
      CodecCandidate candidate;
      candidate.codec = codec;
      candidate.scale = scale;
      candidate.making_ms = extraction + drawing + encoding + decoding;
      if (others > 0 && with[is_video(codec)] == 0) candidate.making_ms += drawing;
      // A change waits for the frame under way: as long as the slowest of the places takes that hold one frame at a time.
      const double wait = std::max({extraction, drawing + encoding, passing.line_ms, decoding});
      candidate.passing_ms = wait + passing.round_trip_ms + passing.line_ms;
      candidate.line_ms = passing.line_ms;
      candidate.likeness = passing.scale * passing.scale * passing.quality / 90;
      candidates.push_back(candidate);
    }
  const Codec before = viewer.choice.codec();
  const std::size_t chosen =
      viewer.frames.moving() ? viewer.choice.choose(candidates, now) : viewer.choice.choose_anew(candidates, now);
  viewer.forecasts.clear();
  for (const CodecCandidate& of : candidates) {
    if (of.scale != candidates[chosen].scale) continue;
    v1::FormatForecast& forecast = viewer.forecasts.emplace_back();
    const double scale = viewer.frames.passing(of.codec, of.scale, now).scale;
    forecast.set_format(std::string(name_of(of.codec)));
    forecast.set_ms(of.ms());
    forecast.set_width(static_cast<std::uint32_t>(std::lround(viewer.frames.width() * scale)));
    forecast.set_height(static_cast<std::uint32_t>(std::lround(viewer.frames.height() * scale)));
  }
  if (viewer.choice.codec() != before && viewer.stream != 0) {
    streams_.leave(viewer.key);
    viewer.stream = 0;
    end_streams();
  }
}

int Session::most_samples(const Viewer& viewer) const {
  int samples = 1;
  if (viewer.refines)
    while (samples < FrameScheduler::kMostSamples && 4 * samples * samples * costs_.drawing.rested_ms() <= kMostRefiningMs) samples *= 2;
  return samples;
}

void Session::use_codec(Viewer& viewer, TimePoint now) {
  if (viewer.chooses && now - viewer.chosen_at >= kChoose) choose_codec(viewer, now);
  const Codec codec = viewer.codec();
  const bool possible = !is_video(codec) || streams_.has_room(viewer.key, now);
  viewer.frames.set_codec(possible ? codec : Codec::jpeg, viewer.chooses ? viewer.choice.scale() : 1);
}

}  // namespace isostrata
