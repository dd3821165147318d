// The cells that a line may meet, out of all cells of a grid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "rendering/picture/view_ray.h"

namespace isostrata {

/// Cells, rising, none of them hidden, among which is each that the ray meets: those with points on all sides of it, or of a grid of boxes, those
/// whose box it meets. Of a grid of boxes they are found by walking, else each point and each cell is looked at once, in parallel, with a byte a point. Throws cancelled. Any thread.
std::vector<std::int64_t> ray_cells(const Grid& grid, const ViewRay& ray, const Task& task);
/// The same of cells on their way from one grid to another of the same cells, wherever on it.
std::vector<std::int64_t> ray_cells(const Grid& first, const Grid& second, const ViewRay& ray, const Task& task);

}  // namespace isostrata
