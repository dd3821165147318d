#include "session/pacing/codec_costs.h"

#include <algorithm>
#include <cmath>

namespace isostrata {
namespace {

constexpr double kMemory = 12;  // frames

double believed(TimePoint learned, TimePoint now) {
  return std::exp(-std::chrono::duration<double>(now - learned) / std::chrono::duration<double>(CodecCosts::kBelieved));
}

}  // namespace

void CodecCosts::measured(Codec codec, double cost, TimePoint now) {
  if (!(cost > 0) || !std::isfinite(cost)) return;
  Known& mine = known_[static_cast<std::size_t>(codec)];
  Codec which = codec;
  const Known* other = in_use(codec, which);
  if (now - mine.at > kPause) {
    mine.count = 0;
    mine.passed_over = other ? kPassedOver : 0;
  }
  mine.at = now;
  if (mine.passed_over > 0) {  // it waited for frames of the one before
    --mine.passed_over;
    return;
  }
  if (++mine.count == 1) {
    mine.mean = cost;
    mine.deviation = 0;
  } else {
    const double weight = 1 / std::min<double>(mine.count, kMemory);
    mine.deviation += weight * (std::abs(cost - mine.mean) - mine.deviation);
    mine.mean += weight * (cost - mine.mean);
  }
  // It has come into use: how it compares with the one before.
  if (mine.count == kEnough && other && now - other->at <= kFresh) turn_ = {codec, which, mine.mean / other->mean, now};
}

// Of the codecs but this one, that was measured last.
const CodecCosts::Known* CodecCosts::in_use(Codec but, Codec& codec) const {
  const Known* newest = nullptr;
  for (std::size_t i = 0; i < kCodecs; ++i)
    if (i != static_cast<std::size_t>(but) && known_[i].count >= kEnough && (!newest || known_[i].at > newest->at))
      newest = &known_[i], codec = static_cast<Codec>(i);
  return newest;
}

double CodecCosts::expected(Codec codec, TimePoint now) const {
  const Known& mine = of(codec);
  Codec other = codec;
  const Known* newest = in_use(codec, other);
  // Who rests measures nothing; what was measured last holds then.
  if (!newest || (mine.count >= kEnough && newest->at - mine.at <= kFresh))
    return mine.count > 0 ? mine.mean + mine.deviation : 0;
  double ratio = usual(codec) / usual(other);
  if (turn_.ratio > 0 && ((turn_.first == codec && turn_.second == other) || (turn_.first == other && turn_.second == codec))) {
    const double learned = turn_.first == codec ? turn_.ratio : 1 / turn_.ratio;
    ratio *= std::pow(learned / ratio, believed(turn_.at, now));
  }
  return ratio * (newest->mean + newest->deviation);
}

void CodecCosts::rescale(double factor) {
  for (Known& of : known_) of.mean *= factor, of.deviation *= factor;
}

void PixelShare::measured(double ms, double pixels, TimePoint now) {
  if (!(ms > 0) || !(pixels > 0)) return;
  if (std::abs(pixels - now_.pixels) > 0.02 * pixels) {
    if (now_.count >= CodecCosts::kEnough) before_ = now_;
    now_ = {pixels, ms, 0};
  }
  ++now_.count;
  now_.ms += (ms - now_.ms) / std::min<double>(now_.count, kMemory);
  if (now_.count == CodecCosts::kEnough) compare(now);
}

void PixelShare::known(double ms, double pixels, bool same, TimePoint now) {
  if (!(ms > 0) || !(pixels > 0)) return;
  const bool other_size = std::abs(pixels - now_.pixels) > 0.02 * pixels;
  if (other_size) before_ = same && now_.count >= CodecCosts::kEnough ? now_ : Size{};
  if (!other_size && !same) before_ = {};
  now_ = {pixels, ms, CodecCosts::kEnough};
  if (other_size) compare(now);
}

void PixelShare::compare(TimePoint now) {
  if (before_.count == 0) return;
  // ms = whole * (1 - share + share * pixels / larger)
  const Size& larger = now_.pixels > before_.pixels ? now_ : before_;
  const Size& smaller = now_.pixels > before_.pixels ? before_ : now_;
  share_ = std::clamp((1 - smaller.ms / larger.ms) / (1 - smaller.pixels / larger.pixels), 0.0, 1.0);
  learned_pixels_ = larger.pixels;
  learned_ = now;
}

double PixelShare::share(TimePoint now) const {
  return learned_pixels_ > 0 ? kUsual + (share_ - kUsual) * believed(learned_, now) : kUsual;
}

double PixelShare::scaled(double ms, double from, double pixels, TimePoint now) const {
  if (!(from > 0)) return ms;
  const double part = share(now), whole = learned_pixels_ > 0 ? learned_pixels_ : std::max(from, pixels);
  const auto shape = [&](double p) { return 1 - part + part * p / whole; };
  return ms * shape(pixels) / shape(from);
}

}  // namespace isostrata
