// Which of a cell's neighbours are in front of it, for one camera.
#pragma once

#include <cstdint>

#include "base/buffer.h"
#include "data/grids/grid.h"
#include "rendering/order/face_graph.h"
#include "scene/camera.h"

namespace isostrata {

/// The camera as a point at a finite or infinite distance: dot(normal, x) - weight * offset is above 0 if it is in front of a
/// plane.
struct OrderView {
  Vec3d x;  // the eye; for parallel rays where they come from
  double weight = 1;
};
OrderView order_view(const Camera& camera);

/// 1: the camera is on the side to which the normal points, -1 on the other, 0 too near to the plane to tell.
inline int side_of(const FacePlane& plane, const OrderView& view, Vec3d center, double margin) {
  const Vec3d x = view.x - center * view.weight;
  const double value =
      plane.normal[0] * x.x + plane.normal[1] * x.y + plane.normal[2] * x.z - view.weight * static_cast<double>(plane.offset);
  return value > margin ? 1 : value < -margin ? -1 : 0;
}
/// The margin for planes in single precision: a few ten-thousandths of a pixel.
double side_margin(const OrderView& view, const FaceGraph& graph);

struct CellRelation {
  // Bit s: the neighbour across slot s is in front. Slots of curvilinear grids: -i, +i, -j, +j, -k, +k. Bit 7 is the sort's.
  Buffer<std::uint8_t> front;    // [cells]
  Buffer<std::uint16_t> behind;  // [cells] how many neighbours are behind
};

/// Parallel.
CellRelation relate_cells(const Grid& grid, const FaceGraph& graph, const Camera& camera);

}  // namespace isostrata
