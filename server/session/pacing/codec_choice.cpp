#include "session/pacing/codec_choice.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace isostrata {
namespace {

constexpr double kSpare = 0.8;       // of kInTimeMs, that a larger size must do with
constexpr double kFarBetter = 1.5;   // what promises so much is tried again in spite of its having been a mistake
constexpr double kAlike = 0.02;      // likenesses that differ by less are the same
constexpr double kFarLighter = 0.5;  // of the bytes, that are a reason of their own...
constexpr double kLineMs = 5;        // ...where they take the line so long...
constexpr double kLighter = 1.2;     // ...and the forecast is no worse than that
constexpr Duration kEarly = std::chrono::seconds(3);  // what is left so soon after it was chosen was a mistake

/// Of the codec, the nearest size that is listed; past the end if it is not listed at all.
std::size_t place_of(const std::vector<CodecCandidate>& candidates, Codec codec, double scale) {
  std::size_t place = candidates.size();
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].codec == codec &&
        (place == candidates.size() || std::abs(candidates[i].scale - scale) < std::abs(candidates[place].scale - scale)))
      place = i;
  return place;
}

}  // namespace

// The largest that one of the codecs makes in time; that of all, where fewer pixels would make it no faster.
double CodecChoice::largest_in_time(const std::vector<CodecCandidate>& candidates) const {
  std::map<double, double, std::greater<>> making;  // of the sooner one, by size
  double least = std::numeric_limits<double>::max();
  for (const CodecCandidate& of : candidates) {
    const auto [it, first] = making.try_emplace(of.scale, of.making_ms);
    it->second = std::min(it->second, of.making_ms);
    least = std::min(least, of.making_ms);
  }
  for (const auto& [scale, ms] : making)
    if (ms <= (scale > scale_ ? kSpare : 1) * kInTimeMs || ms <= kOfUse * least) return scale;
  return making.empty() ? 1 : making.rbegin()->first;
}

std::size_t CodecChoice::choose_anew(const std::vector<CodecCandidate>& candidates, TimePoint now) {
  scale_ = 0;  // so that each size has to be in time with room to spare
  scale_ = largest_in_time(candidates);
  scale_since_.reset();
  const std::size_t place = place_of(candidates, codec_, scale_);
  return place < candidates.size() ? place : choose(candidates, now);
}

std::size_t CodecChoice::choose(const std::vector<CodecCandidate>& candidates, TimePoint now) {
  const auto place_of = [&](Codec codec, double scale) { return isostrata::place_of(candidates, codec, scale); };
  if (const double wanted = largest_in_time(candidates); wanted == scale_) {
    scale_since_.reset();
  } else {
    if (!scale_since_) scale_since_ = now;
    const std::size_t used = place_of(codec_, scale_);
    const bool hurry = wanted < scale_ && used < candidates.size() && candidates[used].making_ms > kTooLong * kInTimeMs;
    if (now - *scale_since_ >= (hurry ? kHurry : kPatience) && now - changed_ >= (hurry ? kHurry : kRest)) {
      scale_ = wanted;
      changed_ = now;
      hurried_ = false;
      scale_since_.reset();
    }
  }

  const std::size_t current = place_of(codec_, scale_);
  const bool gone = current == candidates.size();
  std::vector<std::size_t> sized;  // each codec once
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Codec codec = candidates[i].codec;
    if (i > 0 && candidates[i - 1].codec == codec) continue;
    if (codec == codec_) {
      sized.push_back(current);
      continue;
    }
    const std::size_t place = place_of(codec, scale_);
    const auto past = past_.find(codec);
    const bool regretted = past != past_.end() && now < past->second.not_before;
    if (!regretted || gone || kFarBetter * candidates[place].ms() < candidates[current].ms()) sized.push_back(place);
  }
  const auto ms = [&](std::size_t place) { return candidates[place].ms(); };
  const std::size_t soonest = *std::min_element(sized.begin(), sized.end(), [&](auto a, auto b) { return ms(a) < ms(b); });
  const double least = ms(soonest);
  const auto lighter = [&](std::size_t a, std::size_t b) {
    return candidates[b].line_ms >= kLineMs && candidates[a].line_ms < kFarLighter * candidates[b].line_ms;
  };
  std::size_t best = candidates.size();
  for (const std::size_t place : sized) {
    if (ms(place) > (lighter(place, soonest) ? kLighter : kAsGood) * least) continue;
    if (best == candidates.size()) {
      best = place;
      continue;
    }
    const double more = candidates[place].likeness - candidates[best].likeness;
    const bool sooner = lighter(place, best) || (!lighter(best, place) && ms(place) < ms(best));
    if (more > kAlike || (more > -kAlike && sooner)) best = place;
  }

  const auto change = [&] {
    codec_ = candidates[best].codec;
    changed_ = now;
    worse_since_.reset();
    return best;
  };
  if (gone) return change();
  const bool less_like = candidates[best].likeness > candidates[current].likeness + kAlike;
  if (candidates[best].codec == codec_ ||
      (ms(current) <= (lighter(current, best) ? kMistake : kWorse) * least && !less_like && !lighter(best, current))) {
    worse_since_.reset();
    return current;
  }
  if (!worse_since_) worse_since_ = now;
  const bool mistake = ms(current) > kMistake * ms(best);
  const bool hurry = mistake && !hurried_;
  if (now - *worse_since_ < (mistake ? kHurry : kPatience) || (!hurry && now - changed_ < kRest)) return current;
  hurried_ = hurry && now - changed_ < kRest;
  Past& past = past_[codec_];
  if (!begun_ || now - changed_ >= kEarly) {
    past.regret = kFirstRegret;
  } else {
    past.not_before = now + past.regret;
    past.regret = std::min(2 * past.regret, kLastRegret);
  }
  begun_ = true;
  return change();
}

}  // namespace isostrata
