// Which cells lie behind which across a gap in the mesh.
//
// Sources: P. Williams' MPVONC (1992) sorts the cells at a non-convex boundary by their centroids, which can be wrong. C. Silva,
// J. Mitchell, P. Williams, "An Exact Interactive Time Visibility Ordering Algorithm for Polyhedral Cell Complexes", 1998, find
// out instead which exterior face is behind which; R. Cook, N. Max, C. Silva, P. Williams, "Image-Space Visibility Ordering for
// Cell Projection Volume Rendering of Unstructured Data", 2004, do it by drawing the exterior faces. So here: along each ray of a
// picture, where a ray leaves the mesh and comes back, the cell it comes back into is behind the cell it left.
#pragma once

#include <cstdint>
#include <vector>

#include "rendering/order/face_graph.h"
#include "scene/camera.h"

namespace isostrata {

/// `near` hides some of `far`.
struct CellGap {
  std::uint32_t far, near;
  auto operator<=>(const CellGap&) const = default;
};

/// Right for every ray that is tried: the rays of the picture's pixels if it has up to most_rays, else of every n-th pixel
/// both ways. Sorted, each pair once; pairs in which a cell hides itself are left out. Parallel. O(exterior faces + crossings).
std::vector<CellGap> boundary_gaps(const Grid& grid, const FaceGraph& graph, const Camera& camera, int width, int height,
                                   std::int64_t most_rays = 1 << 16);

}  // namespace isostrata
