// Cell arrays as point arrays.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "import/imported/imported.h"

namespace isostrata {

/// Each point gets the mean over the cells of the file that use it, from both sides of a seam, and are not hidden, NaN if there is none; or what Block::weights says. float32 stays
/// float32 and integers of up to 16 bits become it; everything else becomes float64. on_cells stays set, as the mark of where the values come from.
class CellMeans {
 public:
  /// Both must outlive it.
  CellMeans(const Block& block, const ReadRequest& request);
  /// Of the block's next array on cells, in their order. Precondition: there is one. Some are found together, since looking for the points of cells takes
  /// longer than adding numbers; their sums take at most kMostSums bytes, or those of one array. Means are written to a file of this name in
  /// request.scratch, and mapped.
  FileArray next(const std::string& file);

  static constexpr std::size_t kMostSums = std::size_t{256} << 20;

 private:
  std::size_t together() const;

  const Block& block_;
  const ReadRequest& request_;
  std::vector<const FileArray*> arrays_;
  std::size_t at_ = 0;        // of those that are not averaged yet, the first
  std::size_t summed_ = 0;    // how many from there on are in the sums
  std::vector<double> sums_;  // [points][width_ + 1]
  std::size_t width_ = 0, column_ = 0;
};

}  // namespace isostrata
