// One picture by all ranks: each draws its region, cut at the region's planes, and what they drew is put together front to back.
#pragma once

#include "data/grids/region_tree.h"
#include "rank/composite.h"
#include "rank/rank_line.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// What goes wrong on purpose, so that a comparison of pictures shows that it would see it: $ISOSTRATA_RANKS_CONTROL, "reversed" (the nearest
/// region is put behind all others) or "no-ghosts" (regions have no margin); "no-setup": all ranks but the first fail at their beginning, "silent": they never reply. Empty: nothing.
const char* ranks_control();

/// Memory that was freed and kept for the next time goes to the kernel: parts are large, and ranks share a node.
void give_memory_back();

struct RankedPicture {
  const FloatImage* image = nullptr;  // on the first rank, until the next picture; premultiplied, without depth
  std::vector<float> depth, mean_depth;  // on the first rank, where the input asks for floats with them (FloatImage)
  DrawFacts facts;   // of this rank's own drawing; as stages also how long it waited for the others, and how long compositing took
};

/// By all ranks, with the same input but for what is the rank's own (mesh, values, normals, grid). Priorities are painted one after the other.
/// Throws what this rank's drawing throws; where another rank fails, cancelled on all others.
RankedPicture draw_by_ranks(RankLine& line, Compositor& compositor, Renderer& own, const DrawInput& input, const RegionTree& regions);

}  // namespace isostrata
