#include "data/parts/owned_values.h"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "data/parts/structured_part.h"

namespace isostrata {
namespace {

using Index3 = std::array<std::int64_t, 3>;

/// Of a grid of boxes: the owned points are a box of indices.
StructuredPart owned_box(const Grid& grid, const Box3d& region) {
  StructuredPart box{.of = grid.dims()};
  std::int64_t stride = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const int axis = static_cast<int>(a);
    std::int64_t first = box.of[a], end = 0;
    for (std::int64_t i = 0; i < box.of[a]; ++i) {
      const double at = grid.point(i * stride)[axis];
      if (at < region.lower[axis] || !(at < region.upper[axis])) continue;
      first = std::min(first, i);
      end = i + 1;
    }
    box.from[a] = std::min(first, box.of[a] - 1);
    box.dims[a] = std::max<std::int64_t>(end - first, 0);
    stride *= box.of[a];
  }
  return box;
}

}  // namespace

void for_owned_values(const Grid& part, const PointArray& array, const RegionTree& tree, int region, const Task& task,
                      const std::function<void(const PointArray&)>& look) {
  if (part.rectilinear()) {
    StructuredPart box = owned_box(part, region_box(tree, region));
    if (box.count() == 0) return;
    // Rows at a time, whole layers where they fit.
    const Index3 from = box.from, dims = box.dims;
    const std::int64_t layers = std::clamp<std::int64_t>(kMostOwnedAtOnce / (dims[0] * dims[1]), 1, dims[2]);
    const std::int64_t rows = layers > 1 ? dims[1] : std::clamp<std::int64_t>(kMostOwnedAtOnce / dims[0], 1, dims[1]);
    for (std::int64_t z = 0; z < dims[2]; z += layers)
      for (std::int64_t y = 0; y < dims[1]; y += rows) {
        task.check();
        box.from[1] = from[1] + y, box.dims[1] = std::min(rows, dims[1] - y);
        box.from[2] = from[2] + z, box.dims[2] = std::min(layers, dims[2] - z);
        look(array_of(array, box, task));
      }
    return;
  }
  const std::int64_t points = part.point_count();
  for (std::int64_t begin = 0; begin < points; begin += kMostOwnedAtOnce) {
    task.check();
    const std::int64_t end = std::min(points, begin + kMostOwnedAtOnce);
    PointArray owned = array;
    owned.cells = nullptr;
    std::visit(
        [&](auto all) {
          using T = std::remove_const_t<typename decltype(all)::element_type>;
          auto values = std::make_shared<std::vector<T>>();
          for (std::int64_t p = begin; p < end; ++p)
            if (region_at(tree, part.point(p)) == region) values->push_back(all[static_cast<std::size_t>(p)]);
          owned.values = std::span<const T>(*values);
          owned.storage = std::move(values);
        },
        array.values);
    look(owned);
  }
}

}  // namespace isostrata
