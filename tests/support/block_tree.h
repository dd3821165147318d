// Boxes of cells in levels that tests can make: blocks of which some are refined, again and again.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "import/adaptive/level_lattice.h"

namespace isostrata::test {

struct BlockTree {
  std::array<std::int64_t, 3> roots{2, 2, 2};  // blocks; 0 along a flat axis
  std::int64_t ratio = 2;                      // also the cells along an edge of a block
  int depth = 3;
  bool parents = true;  // blocks that are refined are there, too, under their children
  Vec3d origin{-1, 0.5, 2};
  Vec3d spacing{0.75, 1, 1.25};  // of the coarsest cells
};

/// One block in three is refined, each of its cells by a block of its own.
inline LevelBoxes block_tree(const BlockTree& tree, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  LevelBoxes out;
  const auto flat = [&](int axis) { return tree.roots[static_cast<std::size_t>(axis)] == 0; };
  const auto cells = [&](int axis) { return flat(axis) ? 0 : tree.ratio; };
  const auto add = [&](const auto& self, const Vec3d& origin, const Vec3d& spacing, int depth) -> void {
    const bool refined = depth < tree.depth && random() % 3 == 0;
    if (!refined || tree.parents) out.boxes.push_back({origin, spacing, {cells(0), cells(1), cells(2)}});
    if (!refined) return;
    for (std::int64_t k = 0; k < (flat(2) ? 1 : tree.ratio); ++k)
      for (std::int64_t j = 0; j < (flat(1) ? 1 : tree.ratio); ++j)
        for (std::int64_t i = 0; i < (flat(0) ? 1 : tree.ratio); ++i) {
          // Not every cell of a block that stays has to be covered.
          if (tree.parents && random() % 4 == 0) continue;
          const std::array<std::int64_t, 3> at{i, j, k};
          Vec3d corner = origin, size = spacing;
          for (int axis = 0; axis < 3; ++axis) {
            if (flat(axis)) continue;
            corner[axis] += static_cast<double>(at[static_cast<std::size_t>(axis)]) * spacing[axis];
            size[axis] /= static_cast<double>(tree.ratio);
          }
          self(self, corner, size, depth + 1);
        }
  };
  for (std::int64_t k = 0; k < (flat(2) ? 1 : tree.roots[2]); ++k)
    for (std::int64_t j = 0; j < (flat(1) ? 1 : tree.roots[1]); ++j)
      for (std::int64_t i = 0; i < (flat(0) ? 1 : tree.roots[0]); ++i) {
        const std::array<std::int64_t, 3> at{i, j, k};
        Vec3d corner = tree.origin;
        for (int axis = 0; axis < 3; ++axis)
          if (!flat(axis)) corner[axis] += static_cast<double>(at[static_cast<std::size_t>(axis)] * tree.ratio) * tree.spacing[axis];
        add(add, corner, tree.spacing, 0);
      }
  return out;
}

}  // namespace isostrata::test
