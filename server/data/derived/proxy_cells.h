// The cells of any grid, brought to a small uniform grid.
#pragma once

#include <optional>
#include <vector>

#include "base/task.h"
#include "data/derived/proxy_grid.h"
#include "data/grids/grid.h"

namespace isostrata {

/// [n] for the dims, corner, scale and step of `proxy`: the mean, in shares of the array's range, of points that are spread in
/// every cell so closely that each sample's box gets some; NaN where no cell is. Cells smaller than a sample's box count by their
/// middle, so a shell that is thinner than a box is there too. So do, of more than a million, cells of about that size where others lie so closely that no box
/// is missed. Hidden cells and cells with a value or a place that is not finite
/// are left out, and so are cells with a value that is `missing`.
std::vector<float> sample_cells(const Grid& grid, const PointArray& array, const ProxyGrid& proxy, std::optional<double> missing, const Task& task);

}  // namespace isostrata
