#include "import/adaptive/box_tree.h"

namespace isostrata {

BoxTree::BoxTree(std::span<const CellRange> boxes, std::vector<std::size_t> numbers) {
  items_.reserve(numbers.size());
  for (const std::size_t number : numbers) items_.push_back({boxes[number], number});
  if (!items_.empty()) build(0, items_.size());
}

void BoxTree::build(std::size_t first, std::size_t last) {
  constexpr std::size_t kFew = 4;
  const std::size_t own = nodes_.size();
  CellRange around = items_[first].box, middles;
  const auto middle = [](const Item& item, std::size_t axis) { return item.box.lower[axis] + item.box.extent(axis) / 2; };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    middles.lower[axis] = middles.upper[axis] = middle(items_[first], axis);
    for (std::size_t i = first + 1; i < last; ++i) {
      around.lower[axis] = std::min(around.lower[axis], items_[i].box.lower[axis]);
      around.upper[axis] = std::max(around.upper[axis], items_[i].box.upper[axis]);
      middles.lower[axis] = std::min(middles.lower[axis], middle(items_[i], axis));
      middles.upper[axis] = std::max(middles.upper[axis], middle(items_[i], axis));
    }
  }
  nodes_.push_back({around, first, last, 0});
  if (last - first <= kFew) return;
  std::size_t axis = 0;
  for (std::size_t other = 1; other < 3; ++other)
    if (middles.extent(other) > middles.extent(axis)) axis = other;
  const std::size_t half = first + (last - first) / 2;
  const auto at = [this](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(first), at(half), at(last), [&](const Item& a, const Item& b) { return middle(a, axis) < middle(b, axis); });
  build(first, half);
  nodes_[own].right = nodes_.size();
  build(half, last);
}

}  // namespace isostrata
