// The values at the points that one region owns, out of the part that take_region made for it: what sums over regions are made of.
#pragma once

#include <functional>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "data/grids/region_tree.h"

namespace isostrata {

/// Calls look() with copies of the array's values at the part's points that lie in the region, at most kMostOwnedAtOnce at a time, in the part's
/// order; of those copies only the values are set, name and type are the array's. Every point of a structured grid is looked at by just one region.
/// Throws cancelled.
void for_owned_values(const Grid& part, const PointArray& array, const RegionTree& tree, int region, const Task& task,
                      const std::function<void(const PointArray&)>& look);
inline constexpr std::int64_t kMostOwnedAtOnce = std::int64_t{1} << 21;

}  // namespace isostrata
