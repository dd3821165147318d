// The ranges of a dataset's arrays over its time steps, gathered one step after the other, so that no two steps are held at once.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "data/dataset/dataset.h"

namespace isostrata {

/// Of the finite values; lower > upper if there is none.
struct ValueRange {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -std::numeric_limits<double>::infinity();

  bool empty() const { return !(lower <= upper); }
  bool operator==(const ValueRange&) const = default;
};

/// The least range that holds both.
ValueRange join(const ValueRange& a, const ValueRange& b);

struct ArrayRanges {
  std::string name;
  ValueRange all;                 // over the steps that are known
  std::int64_t nan_count = 0;     // at the step that has most of them
  std::vector<ValueRange> steps;  // [nt]; empty for a step that is not known, or lacks the array
};

/// Steps come in any order; each counts once.
class SeriesRanges {
 public:
  /// Numbers that are kept step by step: arrays times steps. Of a longer series only ArrayRanges::all is known, and `steps` holds
  /// the first step alone.
  static constexpr std::size_t kMostKept = 1 << 14;

  SeriesRanges() = default;
  /// The arrays and the number of steps are those of `step`, whichever of them it is.
  explicit SeriesRanges(const Dataset& step);

  /// Arrays that the first dataset did not have are passed over.
  void add(const Dataset& step);
  /// There are so many steps now, of which nothing is known yet; fewer than before are not believed.
  void grow(int steps);
  /// Nothing can be known of it: the file could not be read.
  void skip(int step);

  int steps() const { return static_cast<int>(known_.size()); }
  int known_steps() const { return count_; }
  bool complete() const { return count_ == steps(); }
  /// The first that is not known; -1 if all are.
  int next() const;
  const std::vector<ArrayRanges>& arrays() const { return arrays_; }
  /// Of all steps that are known.
  const Box3d& bounds() const { return bounds_; }
  /// A word for people where one of them has another box: a mesh that moves, a grid that grows, or files that are not steps of one another.
  std::optional<std::string> note_of_boxes() const;
  /// The step at which this array spans most, the first of several; 0 if that is not kept.
  int widest_step(std::string_view array) const;

 private:
  bool note(int step);
  void include(const Box3d& box);

  std::vector<bool> known_;  // [nt]
  int count_ = 0;
  std::vector<ArrayRanges> arrays_;
  Box3d bounds_;
  bool boxes_differ_ = false;  // by more than a grid of every n-th point from the grid itself
};

}  // namespace isostrata
