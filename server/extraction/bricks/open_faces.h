// Which faces of a brick's active cells no other cell shares: where the domain ends.
#pragma once

#include <array>
#include <cstdint>

#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/cells/active_cells.h"

namespace isostrata {

/// Whether a cell that shares a face with one of the brick's may be absent. Such a cell is in the brick, before it, or in the next one along an
/// axis, which is active if the face holds a part of an interval.
inline bool may_be_beside_absent(const ActiveBricks& active, std::size_t b) {
  if (active.near_absent(b)) return true;
  const BrickLayout& layout = active.layout();
  const auto at = layout.indices(active.bricks()[b].number);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    auto next = at;
    if (++next[axis] == layout.bricks[axis]) continue;
    const std::uint32_t other = active.find(next[0] + layout.bricks[0] * (next[1] + layout.bricks[1] * next[2]));
    if (other != ActiveBricks::kNotActive && active.near_absent(other)) return true;
  }
  return false;
}

/// Whether the brick lies at an end of the grid.
inline bool is_at_end(const BrickLayout& layout, const BrickLayout::Place& place) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (place.first[axis] == 0 || place.first[axis] + place.cells[axis] + 1 == layout.dims[axis]) return true;
  return false;
}

/// Calls visit(record, bits of the faces -x, +x, -y, +y, -z, +z that no other cell shares) for a brick's records.
template <class Visit>
void visit_open_faces(const Grid& grid, const PointArray& array, const ActiveBricks& active, std::size_t b, const Visit& visit) {
  const BrickLayout& layout = active.layout();
  const BrickLayout::Place place = layout.place(active.bricks()[b].number);
  const std::array<std::int64_t, 3> stride{1, layout.dims[0] - 1, (layout.dims[0] - 1) * (layout.dims[1] - 1)};
  const bool may_be_absent = may_be_beside_absent(active, b);
  const bool look = may_be_absent || is_at_end(layout, place);
  int last = -1;
  unsigned open = 0;
  for (const CellRecord& record : active.records(b)) {
    if (look && record.cell() != last) {
      last = record.cell();
      open = 0;
      const std::array<std::int64_t, 3> at{place.first[0] + (last & 7), place.first[1] + (last >> 3 & 7), place.first[2] + (last >> 6)};
      const std::int64_t cell = layout.cell(at);
      for (std::size_t face = 0; face < 6; ++face) {
        const std::size_t axis = face / 2;
        const bool end = face % 2 ? at[axis] + 2 == layout.dims[axis] : at[axis] == 0;
        if (end || (may_be_absent && cell_is_absent(grid, array, face % 2 ? cell + stride[axis] : cell - stride[axis]))) open |= 1u << face;
      }
    }
    visit(record, open);
  }
}

}  // namespace isostrata
