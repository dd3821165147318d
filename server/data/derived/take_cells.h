// A few cells of a dataset as a dataset of their own: what looks at cells along a line needs no more.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "data/dataset/dataset.h"

namespace isostrata {

/// These cells as an unstructured grid, in this order, with their points and the values there, also those that belong to cells. Points are numbered in the
/// order that they have in the whole, so that cells are cut as they are there, and their positions have the same bits. What is said of the whole
/// (bounds, ranges, times) stays that of the whole. Hidden cells are none of it: expected are cells that are not. Any thread.
std::shared_ptr<const Dataset> take_cells(const Dataset& whole, std::span<const std::int64_t> cells);

}  // namespace isostrata
