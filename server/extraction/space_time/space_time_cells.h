// The cells between two time steps, and how each is cut into 4-simplices.
//
// A cell at two steps is a prism over time. The cell is split into tetrahedra by pulling in the order of global point numbers, so
// that neighbours split a shared face alike, whatever their types. The prism over a tetrahedron p0 < p1 < p2 < p3 is split into
// the four 4-simplices p0 ... pi at the first step, pi ... p3 at the second, i = 0 ... 3 (H. W. Kuhn, "Some Combinatorial Lemmas
// in Topology", 1960): again the same on every shared facet. A hexahedron of a structured grid makes 24.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/cells/iso_rules.h"

namespace isostrata {

/// A vertex of a cell at one of two steps: the cell's vertex + kMaxCellVertices * (0 or 1).
using MomentVertex = std::uint8_t;

struct SplitTetrahedron {
  std::array<std::uint8_t, 4> vertex{};  // of the cell, by increasing global number
  bool turned = false;                   // negatively oriented in a right-handed cell
};

/// The split of one cell after the other. One object per thread.
class CellSplit {
 public:
  explicit CellSplit(const Grid& grid) : triangulation_(grid), structured_(grid.structured()) {}

  void begin_cell(std::int64_t cell);
  std::span<const std::int64_t> ids() const { return triangulation_.ids(); }
  const CellTopology& cell() const { return triangulation_.cell(); }
  /// Without those that repeat a point (collapsed cells).
  std::span<const SplitTetrahedron> tetrahedra() const { return tetrahedra_; }
  /// The edges of the prisms' split, each from the vertex whose (step, global number) is smaller.
  std::span<const std::array<MomentVertex, 2>> edges() const { return edges_; }
  /// [n] the cell's faces that hold each vertex.
  std::span<const FaceMask> masks() const { return masks_; }

 private:
  void split();

  CellTriangulation triangulation_;
  bool structured_;
  bool known_ = false;  // cells of a structured grid are all split alike
  std::vector<SplitTetrahedron> tetrahedra_;
  std::vector<std::array<MomentVertex, 2>> edges_;
  std::vector<FaceMask> masks_;
};

/// One interval in one cell that it passes through at some time between the steps.
struct ActiveCell {
  std::int64_t cell = 0;
  std::uint16_t interval = 0;
};

/// The mesh that two steps share, with what is hidden or absent at either of them hidden.
struct SpaceTimeCells {
  std::shared_ptr<const Dataset> first, second;
  const PointArray* at_first = nullptr;
  const PointArray* at_second = nullptr;
  Grid grid;                       // positions of the first step
  std::vector<ActiveCell> active;  // by cell, then by the intervals' lower ends

  double value(std::int64_t point, int step) const { return (step ? at_second : at_first)->at(point); }
  Vec3d position(std::int64_t point, int step) const { return (step ? second : first)->grid.point(point); }
};

/// A cell is left out if it is hidden at a step or has a vertex whose value or position is not finite at a step. One look at
/// each cell at each step. Throws what check_same_cells and array_at_step throw, invalid_argument, too_large, cancelled.
SpaceTimeCells find_space_time_cells(std::shared_ptr<const Dataset> first, std::shared_ptr<const Dataset> second,
                                     const std::string& array, const IsoRules& rules, std::uint64_t max_bytes, const Task& task);

}  // namespace isostrata
