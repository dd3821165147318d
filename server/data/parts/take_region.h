// The part of a dataset that one region needs: what a process that draws or measures that region holds of the whole.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "data/dataset/dataset.h"
#include "data/grids/region_tree.h"
#include "data/parts/structured_part.h"

namespace isostrata {

/// How much around the region comes with it: `layers` layers of cells that share a point with those before. One layer is what gradients at the
/// region's points need, and it keeps the part's own boundary, which is none of the grid's, out of the region.
struct RegionMargin {
  int layers = 1;
};

/// Where a part lies in the whole.
struct PartOrigin {
  StructuredPart box;                // of a structured grid
  std::vector<std::int64_t> points;  // [np] of an unstructured one: the numbers that its points have in the whole, rising
};

/// The cells that meet the region, by their bounding boxes, and the margin, with their points and the values there. What is said of the whole
/// stays that of the whole: bounds, the arrays' ranges, times, counts of cell types, notes. Points are numbered in the order that they
/// have in the whole, so that cells are cut as they are there, and their positions have the same bits: of uniform grids the part is
/// rectilinear; of a curvilinear one it is the box of indices around the cells. There is always a cell (if the whole has one), even if none
/// meets the region. Memory is the part's own, beside that the whole is read once. `origin`, if it is not null, is
/// told where the part lies. Throws too_large. Any thread.
std::shared_ptr<const Dataset> take_region(const Dataset& whole, const RegionTree& tree, int region, const RegionMargin& margin = {},
                                           PartOrigin* origin = nullptr);

}  // namespace isostrata
