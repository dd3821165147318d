// The 3-D cells of a vtkUnstructuredGrid; if it has none, its triangles and quadrilaterals.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/vec.h"
#include "import/imported/imported.h"

class vtkUnstructuredGrid;

namespace isostrata {

/// Points that splitting cells needed, numbered after the file's. The value of any point array at added point i is the sum over
/// k in [first[i], first[i + 1]) of weights[k] times the value at points[k].
struct AddedPoints {
  std::vector<Vec3d> positions;
  std::vector<std::size_t> first{0};  // [added + 1]
  std::vector<std::int64_t> points;   // the file's point ids
  std::vector<double> weights;

  std::size_t size() const { return positions.size(); }
};

struct KeptCells {
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int64_t> connectivity;
  /// If there is an owner, in place of offsets and connectivity: in VTK's memory as we have them, or in a file of the request's folder.
  std::span<const std::int64_t> own_offsets, own_connectivity;
  std::shared_ptr<const void> owner;  // of these
  /// [cells] the cell's number in the file, not decreasing: pieces of one cell follow each other; empty if every cell of the
  /// file is one cell here.
  std::vector<std::int64_t> source;
  AddedPoints added;
};

/// Checks every index before it is used, notes what was skipped, split or made linear. Polyhedra, prisms and the hulls of convex point
/// sets are split as split_polyhedron.h says; polygons of a flat grid become triangles; quadratic and Lagrange cells are divided as
/// divide_cell.h says; Bezier cells are kept by their corners. Throws bad_data.
KeptCells keep_cells(vtkUnstructuredGrid* grid, const ReadRequest& request, std::vector<std::string>& notes);

}  // namespace isostrata
