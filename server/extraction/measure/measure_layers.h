// What a layer measures: volume, areas, centroid, axes, and integrals of arrays over it. Exact for the solid that was extracted, which is made of tetrahedra in
// which everything is linear: over one of volume V the integral of g is V times the mean of its four values, that of x x^T
// V / 20 (sum of p p^T + s s^T), p its corners, s their sum.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/task.h"
#include "extraction/measure/components.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Of where the values are finite; of nothing, zeros.
struct ArrayMeasure {
  double min = 0, mean = 0, max = 0;  // mean: integral / valued
  double integral = 0;
  double deviation = 0;  // the standard deviation over the solid, each part counting by its volume
  double valued = 0;     // the volume in which there are values; of a flat grid the area
};

/// Of facets. Those that touch another layer count at their end and in `contact`.
struct LayerArea {
  double lower = 0, upper = 0, domain = 0, contact = 0;
};

struct LayerMeasure {
  std::uint16_t interval = 0;              // index into IntervalMesh::summaries
  std::optional<std::uint32_t> component;  // of those that were given
  std::int64_t tetrahedra = 0;
  double volume = 0;  // of the solid: signed volumes, so that what is turned counts against it; of a flat grid 0
  LayerArea area;     // of a flat grid: the layer itself, as domain
  Vec3d centroid;
  std::array<Vec3d, 3> axes{};  // of the solid's second moments, the longest first, each as long as the standard deviation along it
  Box3d bounds;
  std::vector<ArrayMeasure> of;  // one per array
};

/// Of each interval, or, with components, of each of its pieces, in their order; an interval without tetrahedra has a row of zeros, and no piece. arrays: as
/// Layers::carried. Precondition: the mesh was extracted with facets. Sums go over blocks of fixed size in their order, so they do not depend on threads.
/// O(tetrahedra + facets); without components parallel. Throws cancelled.
std::vector<LayerMeasure> measure_layers(const IntervalMesh& mesh, std::span<const MeshArray> arrays, const Components* components, const Task& task);

}  // namespace isostrata
