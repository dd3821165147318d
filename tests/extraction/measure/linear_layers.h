// A layer of a linear field that carries another one.
#pragma once

#include <memory>
#include <vector>

#include "extraction/layers/extract_layers.h"
#include "extraction/small_grids.h"

namespace isostrata {

/// 1 <= x <= 3 in a grid of spacing 1 from the origin, with "linear", x + 2y - z.
inline Layers layers_of_linear(std::array<std::int64_t, 3> dims) {
  const Grid grid = uniform_grid(dims);
  std::vector<double> x, linear;
  for (std::int64_t i = 0; i < grid.point_count(); ++i) {
    const Vec3d p = grid.point(i);
    x.push_back(p.x);
    linear.push_back(p.x + 2 * p.y - p.z);
  }
  auto dataset = std::make_shared<Dataset>();
  dataset->grid = grid;
  dataset->arrays = {point_array(x, "x"), point_array(linear, "linear")};
  dataset->times = {0};
  LayerRequest request;
  request.array = "x";
  request.intervals = {{1, 3}};
  request.carry = {"linear"};
  request.facets = true;
  return extract_layers(request, [&](int, const Task&) { return dataset; }, Task{});
}

}  // namespace isostrata
