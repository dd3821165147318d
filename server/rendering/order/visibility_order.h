// The order in which tetrahedra are blended: back to front as the camera sees them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "data/grids/grid.h"
#include "extraction/mesh/interval_mesh.h"
#include "rendering/order/face_graph.h"
#include "scene/camera.h"

namespace isostrata {

struct VisibilityOrder {
  std::vector<std::uint32_t> tetrahedra;  // indices into the mesh, the first is drawn first
  std::string method;                     // as DrawFacts::order names it
  bool exact = false;
};

/// What of the mesh is drawn. [intervals] each.
struct OrderRequest {
  std::span<const std::uint8_t> drawn;      // 0: leave the interval out
  std::span<const std::uint8_t> one_color;  // not 0: one colour and opacity everywhere, so its tetrahedra commute with each other
};

/// The tetrahedra in the mesh's own order: enough where they all have one colour.
VisibilityOrder mesh_order(const IntervalMesh& mesh, const OrderRequest& request);

/// Where an order looks from: the eye, or for an orthographic camera a point so far behind it that its rays are parallel to a
/// ten-millionth of the picture.
Vec3d ordering_eye(const Camera& camera);

/// By the distance of the centroid from the eye (along parallel rays: from its plane): right where tetrahedra are alike in size,
/// wrong for some pairs of long and short neighbours. O(n), radix sort.
VisibilityOrder centroid_order(const IntervalMesh& mesh, const OrderRequest& request, const Camera& camera);

/// Rectilinear grids. Every step of a ray away from the eye raises the index distance |di| + |dj| + |dk| of its cell from the
/// eye's cell (clamped into the grid where the eye is outside or, with parallel rays, infinitely far away), and cells of equal
/// distance cannot hide each other: one counting sort is an exact order of cells. Inside a cell order_in_cell. O(n) in cells;
/// grid.rectilinear() must hold.
VisibilityOrder index_distance_order(const Grid& grid, const IntervalMesh& mesh, const OrderRequest& request,
                                     const Camera& camera);

/// Curvilinear and unstructured grids: all cells in the order of mpvo.h, the tetrahedra inside a cell by order_in_cell. Exact
/// where the grid is convex, its faces are plane and there are no cycles; the method says how many there are.
VisibilityOrder mpvo_order(const Grid& grid, const std::shared_ptr<const FaceGraph>& graph, const IntervalMesh& mesh,
                           const OrderRequest& request, const Camera& camera, int width, int height);

/// index_distance_order where the grid allows it, else mpvo_order; centroid_order where the mesh has no cells, or the grid more
/// than mpvo_order takes. grid may be null. width, height: of the picture, for mpvo_order.
VisibilityOrder visibility_order(const Grid* grid, const IntervalMesh& mesh, const OrderRequest& request, const Camera& camera,
                                 int width = 256, int height = 256);

}  // namespace isostrata
