#include "engine/data/known_ranges.h"

namespace isostrata {

void KnownRanges::add(const std::string& source, const Dataset& step) {
  const SourceStamp stamp = stamp_of(source);
  const std::lock_guard lock(mutex_);
  const auto [it, first] = series_.try_emplace(source);
  Series& series = it->second;
  if (first || series.stamp != stamp || series.known.ranges.steps() != static_cast<int>(step.times.size()))
    series = {stamp, {SeriesRanges(step), {}}};
  else
    series.known.ranges.add(step);
}

void KnownRanges::skip(const std::string& source, int step, const std::string& why) {
  const std::lock_guard lock(mutex_);
  const auto it = series_.find(source);
  if (it == series_.end()) return;
  it->second.known.ranges.skip(step);
  if (it->second.known.notes.size() < kMostNotes)
    it->second.known.notes.push_back("step " + std::to_string(step) + " is left out of the ranges: " + why);
}

std::optional<KnownRanges::Known> KnownRanges::find(const std::string& source) const {
  const std::lock_guard lock(mutex_);
  const auto it = series_.find(source);
  if (it == series_.end()) return std::nullopt;
  return it->second.known;
}

std::optional<int> KnownRanges::next(const std::string& source) const {
  const std::lock_guard lock(mutex_);
  const auto it = series_.find(source);
  if (it == series_.end()) return std::nullopt;
  return it->second.known.ranges.next();
}

}  // namespace isostrata
