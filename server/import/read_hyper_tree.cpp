#include <vtkBitArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkHyperTreeGrid.h>
#include <vtkHyperTreeGridNonOrientedCursor.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkXMLHyperTreeGridReader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "import/leaf_block.h"
#include "import/read_vtk.h"
#include "import/vtk_blocks.h"
#include "import/vtk_messages.h"
#include "import/vtk_pipeline.h"

namespace isostrata {
namespace {

constexpr int kDeepest = 48;

/// The children of each refined cell are a box, and so are all trees' roots.
class TreeBoxes {
 public:
  TreeBoxes(vtkHyperTreeGrid* grid, vtkIdType cells, const ReadRequest& request) : grid_(grid), cell_count_(cells), request_(request), name_(request.file.filename().string()) {}

  void run() {
    read_axes();
    factor_ = grid_->GetBranchFactor();
    if (factor_ < 2 || factor_ > 3) broken("its branch factor is " + std::to_string(factor_) + "; expected 2 or 3");
    LevelBox roots{.origin = {}, .spacing = {1, 1, 1}, .cells = cells_};
    const std::size_t first = add_box(roots);
    vtkHyperTreeGrid::vtkHyperTreeGridIterator at;
    grid_->InitializeTreeIterator(at);
    vtkNew<vtkHyperTreeGridNonOrientedCursor> cursor;
    vtkIdType tree = 0;
    while (at.GetNextTree(tree)) {
      unsigned int i = 0, j = 0, k = 0;
      grid_->GetLevelZeroCoordinatesFromIndex(tree, i, j, k);
      const std::array<std::int64_t, 3> place{i, j, k};
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (place[axis] >= std::max<std::int64_t>(cells_[axis], 1)) broken("tree " + std::to_string(tree) + " does not lie in the grid");
      grid_->InitializeNonOrientedCursor(cursor, tree);
      const Vec3d corner{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
      add_cell(cursor, first + static_cast<std::size_t>(place[0] + roots_along(0) * (place[1] + roots_along(1) * place[2])), corner, 1, 0);
    }
  }

  const LevelBoxes& levels() const { return levels_; }
  std::span<const std::uint8_t> hidden() const { return hidden_; }
  bool any_hidden() const { return std::find(hidden_.begin(), hidden_.end(), 1) != hidden_.end(); }

  std::span<const std::byte> values(const FileArray& array, std::size_t box) {
    const std::size_t tuple = size_of(array.type) * static_cast<std::size_t>(array.components);
    own_.assign((first_[box + 1] - first_[box]) * tuple, std::byte{});
    for (std::size_t cell = first_[box]; cell < first_[box + 1]; ++cell)
      if (node_[cell] >= 0) std::memcpy(&own_[(cell - first_[box]) * tuple], array.values.data() + static_cast<std::size_t>(node_[cell]) * tuple, tuple);
    return own_;
  }

 private:
  [[noreturn]] void broken(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": " + what); }
  std::int64_t roots_along(std::size_t axis) const { return std::max<std::int64_t>(cells_[axis], 1); }

  void read_axes() {
    vtkDataArray* const axes[3] = {grid_->GetXCoordinates(), grid_->GetYCoordinates(), grid_->GetZCoordinates()};
    const unsigned int* const points = grid_->GetDimensions();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cells_[axis] = static_cast<std::int64_t>(points[axis]) - 1;
      const vtkIdType present = axes[axis] ? axes[axis]->GetNumberOfTuples() : 0;
      if (points[axis] < 1 || present < static_cast<vtkIdType>(points[axis]))
        broken("axis " + std::string(1, "xyz"[axis]) + " has " + std::to_string(present) + " coordinates; expected " + std::to_string(points[axis]));
      for (vtkIdType p = 0; p < static_cast<vtkIdType>(points[axis]); ++p) levels_.axes[axis].push_back(axes[axis]->GetComponent(p, 0));
      for (std::size_t p = 0; p < levels_.axes[axis].size(); ++p)
        if (const double at = levels_.axes[axis][p]; !std::isfinite(at) || (p > 0 && !(at > levels_.axes[axis][p - 1])))
          broken("the coordinates along " + std::string(1, "xyz"[axis]) + " do not increase");
    }
    check_bytes(request_, 32 * static_cast<std::uint64_t>(checked_product({roots_along(0), roots_along(1), roots_along(2)}, name_)), name_ + ": its trees");
  }

  /// Returns the number of its first cell.
  std::size_t add_box(const LevelBox& box) {
    levels_.boxes.push_back(box);
    std::size_t count = 1;
    for (const std::int64_t cells : box.cells) count *= static_cast<std::size_t>(std::max<std::int64_t>(cells, 1));
    node_.resize(node_.size() + count, -1);
    hidden_.resize(node_.size(), 1);
    first_.push_back(node_.size());
    return node_.size() - count;
  }

  /// The cell under the cursor, which is number `cell` of all boxes' cells, and what is below it.
  void add_cell(vtkHyperTreeGridNonOrientedCursor* cursor, std::size_t cell, const Vec3d& corner, double size, int depth) {
    if (depth > kDeepest) broken("its trees are above " + std::to_string(kDeepest) + " levels deep");
    const vtkIdType node = cursor->GetGlobalNodeIndex();
    if (node < 0 || node >= cell_count_) broken("a cell has number " + std::to_string(node) + " of " + std::to_string(cell_count_));
    node_[cell] = node;
    hidden_[cell] = cursor->IsMasked();
    if (cursor->IsMasked() || cursor->IsLeaf()) return;
    const double part = size / static_cast<double>(factor_);
    LevelBox box{.origin = corner, .spacing = {part, part, part}};
    for (std::size_t axis = 0; axis < 3; ++axis) box.cells[axis] = cells_[axis] > 0 ? factor_ : 0;
    const std::size_t first = add_box(box);
    const auto along = [&](std::size_t axis) { return box.cells[axis] > 0 ? factor_ : 1u; };
    unsigned char child = 0;
    for (unsigned int k = 0; k < along(2); ++k)
      for (unsigned int j = 0; j < along(1); ++j)
        for (unsigned int i = 0; i < along(0); ++i, ++child) {
          cursor->ToChild(child);
          add_cell(cursor, first + child, {corner.x + i * part, corner.y + j * part, corner.z + k * part}, part, depth + 1);
          cursor->ToParent();
        }
  }

  vtkHyperTreeGrid* const grid_;
  const vtkIdType cell_count_;  // refined ones, too
  const ReadRequest& request_;
  const std::string name_;
  LevelBoxes levels_;  // in numbers of roots
  std::array<std::int64_t, 3> cells_{};
  unsigned int factor_ = 2;
  std::vector<std::size_t> first_{0};  // [boxes + 1]
  std::vector<std::int64_t> node_;     // [cells of all boxes] where its values are; -1: there is no tree
  std::vector<std::uint8_t> hidden_;   // the same
  std::vector<std::byte> own_;
};

}  // namespace

Imported read_hyper_tree(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  vtkNew<vtkXMLHyperTreeGridReader> reader;
  reader->SetFileName(request.file.c_str());
  reader->Update();
  throw_on_vtk_error(name);
  vtkHyperTreeGrid* const grid = vtkHyperTreeGrid::SafeDownCast(reader->GetOutputDataObject(0));
  if (!grid || reader->GetErrorCode() != 0) throw Error(ErrorCode::bad_data, name + ": VTK's reader reported error " + std::to_string(reader->GetErrorCode()));
  Imported imported;
  imported.times = declared_times(grid);
  const vtkIdType cells = grid->GetNumberOfElements(vtkDataObject::CELL);  // by this name in every VTK
  TreeBoxes trees(grid, cells, request);
  trees.run();
  LeafBlock leaves(trees.levels(), request, imported.notes, trees.any_hidden() ? trees.hidden() : std::span<const std::uint8_t>());
  for (const FileArray& array : cell_arrays(grid->GetCellData(), cells, name, imported.notes))
    leaves.add(array, [&](std::size_t box) { return trees.values(array, box); });
  imported.blocks.push_back(leaves.take());
  return imported;
}

}  // namespace isostrata
