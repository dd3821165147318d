// The one rule of equality: on which side of an isovalue a point with just that value lies.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// A point is in class (f >= lower) + (f >= above): 0 below, 1 inside, 2 above. `above` is the interval's upper end where another
/// interval of the request begins there, else the next double after it, so that a closed end holds the points that have it.
struct IsoRule {
  double lower = 0, upper = 0;
  double above = 0;
  std::uint32_t lower_index = 0, upper_index = 0;  // into IsoRules::isovalues

  int class_of(double f) const { return static_cast<int>(f >= lower) + static_cast<int>(f >= above); }
  bool operator==(const IsoRule&) const = default;
};

/// The intervals of one request.
class IsoRules {
 public:
  /// Throws invalid_argument: no interval, more than 65535, an end that is not finite, lower >= upper. With `complement`, rules
  /// for all that lies between, below and above the intervals follow theirs: a value is in just one of them or in an interval.
  explicit IsoRules(std::span<const Interval> intervals, bool complement = false);

  std::span<const IsoRule> rules() const { return rules_; }         // in the order of the request, then the complement's
  std::span<const double> isovalues() const { return isovalues_; }  // distinct, increasing
  bool operator==(const IsoRules&) const = default;
  double lowest() const { return lowest_; }                         // of all lower
  double highest() const { return highest_; }                       // of all above

  /// Calls visit(interval, rule), in the order of `lower`, for every interval in which values that span [minimum, maximum] are
  /// neither all below nor all above. O(log intervals + visits) where intervals do not overlap.
  template <class Visit>
  void visit_active(double minimum, double maximum, Visit&& visit) const {
    std::size_t i = 0;
    if (order_.size() > 4) {  // the first interval whose end, or an earlier one's end, is beyond minimum
      std::size_t last = order_.size();
      while (i < last) {
        const std::size_t middle = (i + last) / 2;
        if (minimum < reach_[middle])
          last = middle;
        else
          i = middle + 1;
      }
    }
    for (; i < order_.size(); ++i) {
      const IsoRule& rule = rules_[order_[i]];
      if (!(maximum >= rule.lower)) return;
      if (minimum < rule.above) visit(order_[i], rule);
    }
  }

 private:
  void add_complement();

  std::vector<IsoRule> rules_;
  std::vector<double> isovalues_;
  std::vector<std::uint16_t> order_;  // intervals by lower
  std::vector<double> reach_;         // [i] the largest `above` of order_[0..i]
  double lowest_ = 0, highest_ = 0;
};

}  // namespace isostrata
