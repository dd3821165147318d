// Walks the rays of a tile through their crossings, front to back.
//
// Between two crossings extinction is constant and the place in the colour map runs linearly, so the light is that of
// color_integrals.h. What the map's antiderivative is at a crossing serves the piece before it and the one behind it. kListLanes
// neighbours are walked together, their state in registers, until nothing more is seen.
#pragma once

#include <array>

#include "rendering/segments/color_integrals.h"
#include "rendering/segments/segment_crossings.h"

namespace isostrata {

struct RayWalk {
  const SegmentView* view = nullptr;
  const ColorIntegrals* integrals = nullptr;
  std::array<float, kMostCrossedIntervals> extinction{};
  bool depth = false;       // nearest_q is wanted
  bool mean_depth = false;  // and mean_depth
  int tile_x = 0, tile_y = 0;
};

/// Sorts the lists and blends what they hold behind what `pixels` holds. Any thread.
void walk_rays(const RayWalk& walk, CrossingLists& lists, SegmentPixels& pixels);

}  // namespace isostrata
