#include <algorithm>
#include <array>
#include <cstring>

#include "import/adaptive/hyper_tree_file.h"
#include "import/adaptive/leaf_block.h"
#include "import/imported/declared_time.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

/// The children of each refined cell are a box, and so are all trees' roots.
class TreeBoxes {
 public:
  TreeBoxes(const HyperTrees& trees, const ReadRequest& request) : trees_(trees), request_(request), name_(request.file.filename().string()) {
    levels_.axes = trees.axes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      roots_[axis] = static_cast<std::int64_t>(trees.axes[axis].size()) - 1;
      along_[axis] = roots_[axis] > 0 ? trees.factor : 1;
    }
    const std::int64_t roots = checked_product({std::max<std::int64_t>(roots_[0], 1), std::max<std::int64_t>(roots_[1], 1), std::max<std::int64_t>(roots_[2], 1)}, name_);
    check_bytes(request_, 32 * static_cast<std::uint64_t>(roots), name_ + ": its trees");
    add_box({.origin = {}, .spacing = {1, 1, 1}, .cells = roots_});
    for (const HyperTrees::Tree& tree : trees.trees) add_tree(tree);
  }

  const LevelBoxes& levels() const { return levels_; }
  std::span<const std::uint8_t> hidden() const { return hidden_; }
  bool any_hidden() const { return std::find(hidden_.begin(), hidden_.end(), 1) != hidden_.end(); }

  std::span<const std::byte> values(const FileArray& array, std::size_t box) {
    const std::size_t tuple = size_of(array.type) * static_cast<std::size_t>(array.components);
    own_.assign((first_[box + 1] - first_[box]) * tuple, std::byte{});
    for (std::size_t cell = first_[box]; cell < first_[box + 1]; ++cell)
      if (number_[cell] >= 0) std::memcpy(&own_[(cell - first_[box]) * tuple], array.values.data() + static_cast<std::size_t>(number_[cell]) * tuple, tuple);
    return own_;
  }

 private:
  struct Cell {
    std::size_t at = kNowhere;  // of all boxes' cells; nowhere below a masked one
    Vec3d corner;
  };

  [[noreturn]] void broken(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": " + what); }

  /// Returns the number of its first cell.
  std::size_t add_box(const LevelBox& box) {
    levels_.boxes.push_back(box);
    std::size_t count = 1;
    for (const std::int64_t cells : box.cells) count *= static_cast<std::size_t>(std::max<std::int64_t>(cells, 1));
    number_.resize(number_.size() + count, -1);
    hidden_.resize(number_.size(), 1);
    first_.push_back(number_.size());
    check_bytes(request_, 9 * number_.size() + sizeof(LevelBox) * levels_.boxes.size(), name_ + ": its trees");
    return number_.size() - count;
  }

  Cell root_of(const HyperTrees::Tree& tree) const {
    std::array<std::int64_t, 3> place{};
    std::int64_t rest = tree.root;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t axis = trees_.transposed ? 2 - i : i;
      const std::int64_t count = std::max<std::int64_t>(roots_[axis], 1);
      place[axis] = rest % count;
      rest /= count;
    }
    if (tree.root < 0 || rest != 0) broken("tree " + std::to_string(tree.root) + " does not lie in the grid");
    const std::int64_t x = std::max<std::int64_t>(roots_[0], 1), y = std::max<std::int64_t>(roots_[1], 1);
    const auto at = static_cast<std::size_t>(place[0] + x * (place[1] + y * place[2]));
    if (number_[at] >= 0) broken("tree " + std::to_string(tree.root) + " is there twice");
    return {at, {static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2])}};
  }

  void add_tree(const HyperTrees::Tree& tree) {
    std::vector<Cell> cells{root_of(tree)};
    std::uint64_t number = tree.first_cell, bit = tree.first_bit;
    double size = 1;
    for (std::size_t level = 0; level < tree.cells.size(); ++level) {
      if (tree.cells[level] != cells.size())
        broken("level " + std::to_string(level) + " of tree " + std::to_string(tree.root) + " has " + std::to_string(tree.cells[level]) + " cells by its number, and " + std::to_string(cells.size()) +
               " by those that are refined");
      const bool last = level + 1 == tree.cells.size();
      size /= trees_.factor;
      std::vector<Cell> finer;
      for (const Cell& cell : cells) {
        const bool masked = trees_.masked[number], refined = !last && trees_.refined[bit++];
        if (cell.at != kNowhere) {
          number_[cell.at] = static_cast<std::int64_t>(number);
          hidden_[cell.at] = masked;
        }
        ++number;
        if (refined) add_children(cell, cell.at == kNowhere || masked, size, finer);
      }
      cells = std::move(finer);
    }
  }

  void add_children(const Cell& cell, bool hidden, double size, std::vector<Cell>& to) {
    LevelBox box{.origin = cell.corner, .spacing = {size, size, size}};
    for (std::size_t axis = 0; axis < 3; ++axis) box.cells[axis] = roots_[axis] > 0 ? along_[axis] : 0;
    std::size_t next = hidden ? kNowhere : add_box(box);
    for (int k = 0; k < along_[2]; ++k)
      for (int j = 0; j < along_[1]; ++j)
        for (int i = 0; i < along_[0]; ++i) to.push_back({hidden ? kNowhere : next++, {cell.corner.x + i * size, cell.corner.y + j * size, cell.corner.z + k * size}});
    check_bytes(request_, sizeof(Cell) * to.size(), name_ + ": its trees");
  }

  const HyperTrees& trees_;
  const ReadRequest& request_;
  const std::string name_;
  LevelBoxes levels_;                    // in numbers of roots
  std::array<std::int64_t, 3> roots_{};  // along each axis; 0: it is flat
  std::array<std::int64_t, 3> along_{};  // children
  std::vector<std::size_t> first_{0};    // [boxes + 1]
  std::vector<std::int64_t> number_;     // [cells of all boxes] where its values are; -1: there is no tree
  std::vector<std::uint8_t> hidden_;     // the same
  std::vector<std::byte> own_;
};

}  // namespace

Imported read_hyper_tree(const ReadRequest& request) {
  check_step(request, 1);
  Imported imported;
  const HyperTrees trees = read_hyper_trees(request, imported.notes);
  imported.times = {declared_time(request.file).value_or(0)};
  TreeBoxes boxes(trees, request);
  LeafBlock leaves(boxes.levels(), request, imported.notes, boxes.any_hidden() ? boxes.hidden() : std::span<const std::uint8_t>());
  for (const FileArray& array : trees.values) leaves.add(array, [&](std::size_t box) { return boxes.values(array, box); });
  imported.blocks.push_back(leaves.take());
  return imported;
}

}  // namespace isostrata
