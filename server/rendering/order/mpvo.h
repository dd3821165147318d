// The visibility order of all cells of a curvilinear or unstructured grid.
//
// Sources: P. Williams, "Visibility Ordering Meshed Polyhedra", 1992 (MPVO): of two cells with a common face the one on the
// viewpoint's side of it is in front, and a topological sort of that relation is a visibility order where the mesh is convex and
// has one. Where it is not convex (MPVONC), what lies behind what across the gaps comes from boundary_gaps.h. Section 4 of the
// paper.
#pragma once

#include <cstdint>
#include <memory>

#include "base/buffer.h"
#include "data/grids/grid.h"
#include "rendering/order/face_graph.h"
#include "scene/camera.h"

namespace isostrata {

struct CellSequence {
  Buffer<std::uint32_t> cells;  // far ones first; hidden ones too, anywhere
  std::int64_t cycles = 0;      // of cells that hide each other in a ring, each broken at its farthest cell
  std::int64_t gaps = 0;        // pairs of cells ordered across gaps
  bool exact = false;           // for every ray: convex, of plane faces, without cycles
  bool convex = false;
};

/// For rays of a picture of this size (boundary_gaps.h). Only cells seen edge-on, to a thousandth of a pixel, have no order.
/// O(cells), a few tens of nanoseconds each; the relation is found in parallel, the sort is serial. Any thread.
CellSequence sort_cells(const Grid& grid, const FaceGraph& graph, const Camera& camera, int width, int height);

/// The same, kept for the graph, camera and size asked for last: dragging a slider does not sort anew.
std::shared_ptr<const CellSequence> cell_sequence(const Grid& grid, const std::shared_ptr<const FaceGraph>& graph,
                                                  const Camera& camera, int width, int height);

}  // namespace isostrata
