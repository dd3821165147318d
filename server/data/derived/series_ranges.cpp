#include "data/derived/series_ranges.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace isostrata {

ValueRange join(const ValueRange& a, const ValueRange& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return {std::min(a.lower, b.lower), std::max(a.upper, b.upper)};
}

SeriesRanges::SeriesRanges(const Dataset& step) : known_(step.times.size(), false) {
  const bool keep = step.arrays.size() * step.times.size() <= kMostKept;
  for (const PointArray& array : step.arrays) {
    ArrayRanges& ranges = arrays_.emplace_back();
    ranges.name = array.name;
    ranges.steps.resize(keep ? step.times.size() : std::min<std::size_t>(step.times.size(), 1));
  }
  add(step);
}

bool SeriesRanges::note(int step) {
  if (step < 0 || step >= steps() || known_[static_cast<std::size_t>(step)]) return false;
  known_[static_cast<std::size_t>(step)] = true;
  ++count_;
  return true;
}

void SeriesRanges::include(const Box3d& box) {
  if (box.empty()) return;
  const Box3d before = bounds_;
  bounds_.include(box.lower);
  bounds_.include(box.upper);
  if (before.empty()) return;
  for (int axis = 0; axis < 3; ++axis) {
    const double most = 0.02 * (bounds_.upper[axis] - bounds_.lower[axis]);
    boxes_differ_ = boxes_differ_ || std::abs(before.lower[axis] - box.lower[axis]) > most || std::abs(before.upper[axis] - box.upper[axis]) > most;
  }
}

std::optional<std::string> SeriesRanges::note_of_boxes() const {
  if (!boxes_differ_) return std::nullopt;
  std::ostringstream out;
  out << "steps lie in boxes of their own; all that were read in";
  for (int axis = 0; axis < 3; ++axis) out << ' ' << "xyz"[axis] << " [" << bounds_.lower[axis] << ", " << bounds_.upper[axis] << ']';
  return out.str();
}

void SeriesRanges::add(const Dataset& step) {
  if (!note(step.step)) return;
  include(step.bounds);
  const auto at = static_cast<std::size_t>(step.step);
  for (std::size_t i = 0; i < arrays_.size(); ++i) {
    ArrayRanges& ranges = arrays_[i];
    const PointArray* array = i < step.arrays.size() && step.arrays[i].name == ranges.name ? &step.arrays[i] : nullptr;
    for (auto it = step.arrays.begin(); !array && it != step.arrays.end(); ++it)
      if (it->name == ranges.name) array = &*it;
    if (!array) continue;
    ranges.nan_count = std::max(ranges.nan_count, array->nan_count);
    const ValueRange range{array->lower, array->upper};
    if (range.empty()) continue;
    ranges.all = join(ranges.all, range);
    if (at < ranges.steps.size()) ranges.steps[at] = range;
  }
}

void SeriesRanges::grow(int wanted) {
  if (wanted <= steps()) return;
  const bool keep = arrays_.size() * static_cast<std::size_t>(wanted) <= kMostKept;
  known_.resize(static_cast<std::size_t>(wanted), false);
  for (ArrayRanges& array : arrays_) array.steps.resize(keep ? static_cast<std::size_t>(wanted) : std::min<std::size_t>(array.steps.size(), 1));
}

void SeriesRanges::skip(int step) { note(step); }

int SeriesRanges::next() const {
  const auto found = std::find(known_.begin(), known_.end(), false);
  return found == known_.end() ? -1 : static_cast<int>(found - known_.begin());
}

int SeriesRanges::widest_step(std::string_view name) const {
  for (const ArrayRanges& array : arrays_) {
    if (array.name != name) continue;
    const auto width = [](const ValueRange& range) { return range.empty() ? -1 : range.upper / 2 - range.lower / 2; };
    const auto widest = std::max_element(array.steps.begin(), array.steps.end(),
                                         [&](const ValueRange& a, const ValueRange& b) { return width(a) < width(b); });
    return widest == array.steps.end() ? 0 : static_cast<int>(widest - array.steps.begin());
  }
  return 0;
}

}  // namespace isostrata
