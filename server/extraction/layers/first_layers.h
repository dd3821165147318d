// Layers for a field that nobody has looked at yet.
#pragma once

#include <cstdint>
#include <vector>

#include "base/task.h"
#include "data/array.h"
#include "data/grid.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// How many cells the first picture of a dataset may cut, so that it comes at once on a machine without a GPU too.
inline constexpr std::int64_t kFirstPictureCells = 100'000;

/// At most four intervals, increasing, for the first picture of an array. A grid of up to `cell_budget` cells is cut whole, into
/// the four quarters of the array's range. A larger one gets thin layers around the middles of the quarters, each as thick as its
/// share of the budget allows, or half as costly again as the thinnest; those that do not fit at all are left out, the costliest
/// first, but one stays. The cells that a layer cuts are counted, not guessed: one pass over the cells' ranges (the contour
/// spectrum of C. Bajaj, V. Pascucci, D. Schikore, "The Contour Spectrum", 1997, for numbers of cells). Empty for an array
/// without two different finite values. O(cells). Throws cancelled. Any thread.
std::vector<Interval> first_layers(const Grid& grid, const PointArray& array, std::int64_t cell_budget, const Task& task);

}  // namespace isostrata
