// Grids of levels keep the laws of all meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "data/dataset/dataset.h"
#include "laws/partition_law.h"
#include "support/block_tree.h"
#include "support/level_files.h"

namespace isostrata {
namespace {

double bump(const Vec3d& p) { return std::exp(-dot(p, p) / 8); }

TEST(LevelLaws, IntervalsTileTheDomainWithoutAGap) {
  const test::BlockTree trees[] = {{.roots = {3, 2, 2}, .depth = 2}, {.roots = {2, 2, 1}, .ratio = 4, .depth = 1}, {.depth = 3, .parents = false}, {.roots = {1, 2, 1}, .ratio = 3, .depth = 2}};
  for (const test::BlockTree& tree : trees)
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
      SCOPED_TRACE("ratio " + std::to_string(tree.ratio) + ", depth " + std::to_string(tree.depth) + ", seed " + std::to_string(seed));
      const testing::TemporaryFolder folder;
      const auto data = open_dataset(testing::write_vthb(folder, "levels", test::block_tree(tree, seed), bump).string(), {}, Task());
      double volume = 1;
      for (int axis = 0; axis < 3; ++axis) volume *= static_cast<double>(tree.roots[static_cast<std::size_t>(axis)] * tree.ratio) * tree.spacing[axis];
      const PointArray& array = data->arrays.front();
      const laws::Solid all = laws::measure_solid(*data, array, {{-1, 2}}, nullptr);
      EXPECT_NEAR(all.signed_volume, volume, 1e-12 * volume);
      EXPECT_EQ(all.unmatched, 0);
      const laws::Partition law = laws::partition_law(*data, array, 5, 200'000);
      EXPECT_EQ(law.whole.unmatched, 0);
      EXPECT_EQ(law.cut.unmatched, 0);
      EXPECT_GT(law.active_cells, 0);
      EXPECT_LE(law.unexplained(), 1e-11) << "partition error " << law.error();
    }
}

TEST(LevelLaws, ABallOverThreeLevelsHasItsVolume) {
  // The finest cells are at its surface on one side only: the surface passes through two jumps.
  const LevelBoxes levels{.boxes = {{{-1, -1, -1}, {0.125, 0.125, 0.125}, {16, 16, 16}},
                                    {{-0.75, -0.75, -0.75}, {0.0625, 0.0625, 0.0625}, {24, 24, 12}},
                                    {{-0.5, -0.5, -0.75}, {0.03125, 0.03125, 0.03125}, {32, 16, 16}}},
                          .axes = {}};
  const testing::TemporaryFolder folder;
  const auto data = open_dataset(testing::write_vthb(folder, "ball", levels, [](const Vec3d& p) { return length(p); }).string(), {}, Task());
  const laws::Solid ball = laws::measure_solid(*data, data->arrays.front(), {{0, 0.6}}, nullptr);
  EXPECT_EQ(ball.unmatched, 0);
  // Means over cells make the ball smaller, by the square of the cells' size: so it is with the coarsest level alone, and less with the finer ones.
  const auto coarse = open_dataset(testing::write_vthb(folder, "coarse", {.boxes = {levels.boxes.front()}, .axes = {}}, [](const Vec3d& p) { return length(p); }).string(), {}, Task());
  const double exact = 4 / 3.0 * std::acos(-1.0) * 0.6 * 0.6 * 0.6, of_coarse = laws::measure_solid(*coarse, coarse->arrays.front(), {{0, 0.6}}, nullptr).signed_volume;
  EXPECT_NEAR(ball.signed_volume, exact, 0.032 * exact);
  EXPECT_LT(ball.signed_volume, exact);
  EXPECT_GT(ball.signed_volume, of_coarse);
}

}  // namespace
}  // namespace isostrata
