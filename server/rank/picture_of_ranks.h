// One picture by all ranks: each draws its region, cut at the region's planes, and what they drew is put together front to back.
#pragma once

#include "data/region_tree.h"
#include "rank/composite.h"
#include "rank/rank_line.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// What goes wrong on purpose, so that a comparison of pictures shows that it would see it: $ISOSTRATA_RANKS_CONTROL, "reversed" (the nearest
/// region is put behind all others) or "no-ghosts" (regions have no margin). Empty: nothing.
const char* ranks_control();

struct RankedPicture {
  FloatImage image;  // on the first rank; premultiplied, with depth where the input asks for floats
  DrawFacts facts;   // of this rank's own drawing
};

/// By all ranks, with the same input but for what is the rank's own (mesh, values, normals, grid). Priorities are painted one after the other.
/// Throws what this rank's drawing throws; where another rank fails, cancelled on all others.
RankedPicture draw_by_ranks(RankLine& line, Compositor& compositor, Renderer& own, const DrawInput& input, const RegionTree& regions);

}  // namespace isostrata
