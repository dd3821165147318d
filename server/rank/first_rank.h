// The first rank of a parallel job: runs the command or the engine as any other process does, and has the others extract and draw with it.
#pragma once

#include <memory>

#include "engine/picture/scene_ranks.h"
#include "rank/rank_line.h"

namespace isostrata {

/// Tells the other ranks to end when it is destroyed.
std::unique_ptr<SceneRanks> lead_ranks(RankLine& line);

}  // namespace isostrata
