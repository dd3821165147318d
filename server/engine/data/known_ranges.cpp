#include "engine/data/known_ranges.h"

namespace isostrata {

void KnownRanges::add(const std::string& source, const Dataset& step) {
  const std::lock_guard lock(mutex_);
  const auto [it, first] = series_.try_emplace(source);
  Known& known = it->second;
  if (first)
    known.ranges = SeriesRanges(step);
  else
    known.ranges.grow(static_cast<int>(step.times.size()));
  known.ranges.add(step);
  if (step.times.size() <= known.times.size()) return;
  known.times = step.times;
  known.said = step.notes;
}

void KnownRanges::skip(const std::string& source, int step, const std::string& why) {
  const std::lock_guard lock(mutex_);
  const auto it = series_.find(source);
  if (it == series_.end()) return;
  it->second.ranges.skip(step);
  if (it->second.notes.size() < kMostNotes)
    it->second.notes.push_back("step " + std::to_string(step) + " is left out of the ranges: " + why);
}

std::optional<KnownRanges::Known> KnownRanges::find(const std::string& source) const {
  const std::lock_guard lock(mutex_);
  const auto it = series_.find(source);
  if (it == series_.end()) return std::nullopt;
  return it->second;
}

std::optional<int> KnownRanges::next(const std::string& source) const {
  const std::lock_guard lock(mutex_);
  const auto it = series_.find(source);
  if (it == series_.end()) return std::nullopt;
  return it->second.ranges.next();
}

}  // namespace isostrata
