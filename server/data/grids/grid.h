// Grids: where the points are and how cells join them. Immutable once loaded; shared between threads as shared_ptr<const
// Dataset>.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/vec.h"
#include "tables/cell_type.h"

namespace isostrata {

/// Points origin + index * spacing.
struct UniformGrid {
  std::array<std::int64_t, 3> dims{};  // points along x, y, z; x varies fastest
  Vec3d origin{};
  Vec3d spacing{1, 1, 1};  // any finite value but 0; negative mirrors
};

/// Points (x[i], y[j], z[k]), each axis strictly monotone.
struct RectilinearGrid {
  std::array<std::int64_t, 3> dims{};
  std::array<std::vector<double>, 3> axes;  // [dims[0]], [dims[1]], [dims[2]]
};

/// Positions in the file's precision.
using PointSpan = std::variant<std::span<const Vec3f>, std::span<const Vec3d>>;

/// Hexahedra (i,j,k) between points (i,j,k) and (i+1,j+1,k+1).
struct CurvilinearGrid {
  std::array<std::int64_t, 3> dims{};
  PointSpan points;  // [dims[2]][dims[1]][dims[0]]
};

/// Linear cells, all of them 3-D or all of them flat; what else was in the file is counted in Dataset::notes.
struct UnstructuredGrid {
  PointSpan points;                            // [np]
  std::span<const std::uint8_t> types;         // [nc] CellType values
  std::span<const std::int64_t> offsets;       // [nc + 1] into connectivity
  std::span<const std::int64_t> connectivity;  // point ids, VTK's order
};

/// VTK's point order of the hexahedron at (i,j,k) of a structured grid, as offsets in i, j and k.
inline constexpr std::array<std::array<std::int64_t, 3>, 8> kHexahedronCorners{
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};

/// In Grid::hidden_cells: a copy of a cell that another piece of the same grid has as its own.
inline constexpr std::uint8_t kGhostCell = 2;

/// One of the four, with what is common to them. Points of structured grids are numbered i + dims[0] * (j + dims[1] * k), cells
/// likewise with dims - 1. A structured grid that is one point thick in just one direction is flat: its cells are quadrilaterals, turned as
/// the two other directions are. One that is one point thick in more directions has no cells.
struct Grid {
  std::variant<UniformGrid, RectilinearGrid, CurvilinearGrid, UnstructuredGrid> shape;
  std::span<const std::uint8_t> hidden_cells;  // [nc], 1 = blanked, kGhostCell: not part of the volume; 0 = is; empty = none hidden
  std::shared_ptr<const void> storage;         // keeps the spans alive

  const char* kind_name() const;  // "uniform", "rectilinear", "curvilinear", "unstructured"
  bool structured() const { return !std::holds_alternative<UnstructuredGrid>(shape); }
  bool flat() const;  // its cells are triangles and quadrilaterals: they have an area and no volume
  bool rectilinear() const { return shape.index() <= 1; }  // uniform or rectilinear: cells are boxes
  std::array<std::int64_t, 3> dims() const;                // structured grids only
  std::int64_t point_count() const;
  std::int64_t cell_count() const;
  /// Branches on the kind of grid and divides by dims on structured ones: a few nanoseconds. Loops over all points of a
  /// structured grid that need less take the shape by std::get_if and walk its indices.
  Vec3d point(std::int64_t id) const;
  CellType cell_type(std::int64_t cell) const;
  /// Writes the cell's global point ids in VTK's order to ids; returns how many.
  int cell_points(std::int64_t cell, std::array<std::int64_t, kMaxCellVertices>& ids) const;
  bool hidden(std::int64_t cell) const { return !hidden_cells.empty() && hidden_cells[static_cast<std::size_t>(cell)] != 0; }
  Box3d bounds() const;  // of all points; computed at each call
};

/// How many cells of each kind: "hexahedron" -> count. Hidden ones included.
std::map<std::string, std::int64_t> count_cell_types(const Grid& grid);

}  // namespace isostrata
