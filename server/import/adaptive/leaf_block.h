// The leaves of boxes in levels as a block, for readers of any format that has such boxes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "import/adaptive/level_lattice.h"
#include "import/imported/imported.h"

namespace isostrata {

class LeafBlock {
 public:
  /// Notes how many levels and leaves there are. `hidden`, of all boxes' cells one box after the other, or empty: 1 if a cell is not part of the volume. Throws as lattice_of and
  /// leaf_cells do. The request must outlive it.
  LeafBlock(const LevelBoxes& levels, const ReadRequest& request, std::vector<std::string>& notes, std::span<const std::uint8_t> hidden = {});

  /// One box's values of an array: [its cells][components], x fastest, in the array's type.
  using ValuesOfBox = std::function<std::span<const std::byte>(std::size_t box)>;
  /// Adds an array on cells. Of `like` name, type and components count. `values` is asked once for each box that has leaves, and not again before its answer was used.
  void add(const FileArray& like, const ValuesOfBox& values);

  Block take() { return std::move(block_); }

 private:
  struct Run {
    std::size_t box = 0, first = 0, last = 0;  // these leaves are of this box
  };

  const ReadRequest& request_;
  Block block_;
  std::vector<Run> runs_;
  std::vector<std::int64_t> in_box_;     // [leaves] which of its box's cells
  std::vector<std::size_t> first_cell_;  // [leaves + 1] of the grid's cells
  std::uint64_t bytes_ = 0;              // of all arrays
};

}  // namespace isostrata
