// A rank but the first: does what it is told until it is told to end.
#pragma once

#include "rank/rank_line.h"

namespace isostrata {

void serve_orders(RankLine& line);

}  // namespace isostrata
