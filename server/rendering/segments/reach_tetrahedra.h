// Which tetrahedra of a grid reach into which intervals: blocks by their range first, then in vectors.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "extraction/surfaces/base_tetrahedra.h"

namespace isostrata {

inline constexpr std::size_t kReachBlocks = 128;  // of tetrahedra, that are worth a task of their own

struct ReachOf {
  ValueBounds bounds;
  std::uint32_t interval = 0;
};

struct Reach {
  std::uint32_t tetrahedron = 0, interval = 0;
};

/// Appends what blocks [first, last) reach, block by block and in each by interval. Any thread.
void reach_tetrahedra(const TetrahedronRanges& ranges, std::size_t first, std::size_t last, std::span<const ReachOf> intervals,
                      std::vector<Reach>& out);

}  // namespace isostrata
