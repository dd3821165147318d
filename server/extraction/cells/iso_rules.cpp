#include "extraction/cells/iso_rules.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <sstream>
#include <string>

#include "base/error.h"
#include "extraction/mesh/open_ends.h"

namespace isostrata {
namespace {

std::string text(const Interval& interval) {
  std::ostringstream out;
  out.precision(17);
  out << interval.lower << ":" << interval.upper;
  return out.str();
}

}  // namespace

IsoRules::IsoRules(std::span<const Interval> intervals, bool complement) {
  constexpr std::size_t kMaxIntervals = std::numeric_limits<std::uint16_t>::max();
  if (intervals.empty()) throw Error(ErrorCode::invalid_argument, "no interval given; expected at least one");
  if (intervals.size() > kMaxIntervals)
    throw Error(ErrorCode::invalid_argument,
                std::to_string(intervals.size()) + " intervals given; expected at most " + std::to_string(kMaxIntervals));
  std::vector<double> begins;
  for (const Interval& asked : intervals) {
    const Interval interval = with_finite_ends(asked);
    if (std::isnan(asked.lower) || std::isnan(asked.upper))
      throw Error(ErrorCode::invalid_argument, "interval " + text(asked) + ": an end is not a number; expected -inf or inf for an open end");
    if (!(interval.lower < interval.upper))
      throw Error(ErrorCode::invalid_argument, "interval " + text(asked) + ": lower must be less than upper");
    begins.push_back(interval.lower);
    isovalues_.push_back(interval.lower);
    isovalues_.push_back(interval.upper);
  }
  if (complement) {  // no value lies beyond: nothing crosses these
    isovalues_.push_back(std::numeric_limits<double>::lowest());
    isovalues_.push_back(std::numeric_limits<double>::max());
  }
  std::sort(begins.begin(), begins.end());
  std::sort(isovalues_.begin(), isovalues_.end());
  isovalues_.erase(std::unique(isovalues_.begin(), isovalues_.end()), isovalues_.end());
  const auto index = [&](double value) {
    return static_cast<std::uint32_t>(std::lower_bound(isovalues_.begin(), isovalues_.end(), value) - isovalues_.begin());
  };

  lowest_ = std::numeric_limits<double>::infinity();
  highest_ = -std::numeric_limits<double>::infinity();
  for (const Interval& asked : intervals) {
    const Interval interval = with_finite_ends(asked);
    IsoRule rule;
    rule.lower = interval.lower;
    rule.upper = interval.upper;
    const bool another_begins = std::binary_search(begins.begin(), begins.end(), rule.upper);
    rule.above = another_begins ? rule.upper : std::nextafter(rule.upper, std::numeric_limits<double>::infinity());
    rule.lower_index = index(rule.lower);
    rule.upper_index = index(rule.upper);
    rules_.push_back(rule);
  }
  if (complement) add_complement();
  if (rules_.size() > kMaxIntervals)
    throw Error(ErrorCode::invalid_argument,
                std::to_string(intervals.size()) + " intervals given, and " + std::to_string(rules_.size() - intervals.size()) +
                    " between and around them are needed; expected at most " + std::to_string(kMaxIntervals) + " of both");
  for (const IsoRule& rule : rules_) {
    lowest_ = std::min(lowest_, rule.lower);
    highest_ = std::max(highest_, rule.above);
  }

  order_.resize(rules_.size());
  std::iota(order_.begin(), order_.end(), std::uint16_t{0});
  std::stable_sort(order_.begin(), order_.end(), [&](auto a, auto b) { return rules_[a].lower < rules_[b].lower; });
  double reach = -std::numeric_limits<double>::infinity();
  for (const std::uint16_t i : order_) reach_.push_back(reach = std::max(reach, rules_[i].above));
}

void IsoRules::add_complement() {
  std::vector<IsoRule> sorted(rules_);
  std::sort(sorted.begin(), sorted.end(), [](const IsoRule& a, const IsoRule& b) { return a.lower < b.lower; });
  // What has been passed ends at the isosurface upper_index, and the values that belong to it before `above`.
  IsoRule reach;
  reach.above = std::numeric_limits<double>::lowest();
  const auto add = [&](double upper, double above, std::uint32_t upper_index) {
    IsoRule gap;
    gap.lower = reach.above;
    gap.lower_index = reach.upper_index;
    gap.upper = upper;
    gap.above = above;
    gap.upper_index = upper_index;
    rules_.push_back(gap);
  };
  for (const IsoRule& rule : sorted) {
    if (reach.above == std::numeric_limits<double>::lowest() ? rule.lower > reach.above : rule.lower > reach.upper)
      add(rule.lower, rule.lower, rule.lower_index);
    if (rule.above > reach.above) reach = rule;
  }
  constexpr double kHighest = std::numeric_limits<double>::max();
  if (reach.above <= kHighest)
    add(kHighest, std::numeric_limits<double>::infinity(), static_cast<std::uint32_t>(isovalues_.size() - 1));
}

}  // namespace isostrata
