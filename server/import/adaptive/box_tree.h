// Boxes of whole numbers, and which of many meet one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isostrata {

/// The cells i with lower <= i < upper along each axis.
struct CellRange {
  std::array<std::int64_t, 3> lower{}, upper{};

  bool empty() const { return lower[0] >= upper[0] || lower[1] >= upper[1] || lower[2] >= upper[2]; }
  std::int64_t extent(std::size_t axis) const { return upper[axis] - lower[axis]; }
  std::int64_t count() const { return empty() ? 0 : extent(0) * extent(1) * extent(2); }  // precondition: it fits
};

inline CellRange intersection(const CellRange& a, const CellRange& b) {
  CellRange out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.lower[i] = std::max(a.lower[i], b.lower[i]);
    out.upper[i] = std::min(a.upper[i], b.upper[i]);
  }
  return out;
}

/// The quotient, rounded towards minus infinity; by > 0.
inline std::int64_t divided_down(std::int64_t value, std::int64_t by) { return value >= 0 ? value / by : -((-value + by - 1) / by); }

/// A tree of boxes within boxes, halved by the middles of its boxes: O(n log n) to make, whatever their sizes are. Any thread may ask.
class BoxTree {
 public:
  BoxTree() = default;
  /// `numbers`: which of `boxes` it is of.
  BoxTree(std::span<const CellRange> boxes, std::vector<std::size_t> numbers);

  /// use(number, box) for each box that has a cell in `range`, in no order that means anything.
  template <class Use>
  void for_each_meeting(const CellRange& range, const Use& use) const {
    if (!nodes_.empty()) visit(0, range, use);
  }

 private:
  struct Node {
    CellRange around;
    std::size_t first = 0, last = 0;  // into items_
    std::size_t right = 0;            // the left half follows; 0: none, its items are to be looked at
  };
  struct Item {
    CellRange box;
    std::size_t number = 0;
  };

  void build(std::size_t first, std::size_t last);

  template <class Use>
  void visit(std::size_t at, const CellRange& range, const Use& use) const {
    const Node& node = nodes_[at];
    if (intersection(node.around, range).empty()) return;
    if (node.right != 0) {
      visit(at + 1, range, use);
      visit(node.right, range, use);
      return;
    }
    for (std::size_t i = node.first; i < node.last; ++i)
      if (!intersection(items_[i].box, range).empty()) use(items_[i].number, items_[i].box);
  }

  std::vector<Item> items_;
  std::vector<Node> nodes_;
};

}  // namespace isostrata
