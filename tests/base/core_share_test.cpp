#include "base/core_share.h"

#include <gtest/gtest.h>

#include <numeric>

#include "base/parallel.h"

namespace isostrata {
namespace {

std::vector<int> sum(const std::vector<std::vector<int>>& of) {
  std::vector<int> all(of.front().size(), 0);
  for (const auto& own : of)
    for (std::size_t i = 0; i < own.size(); ++i) all[i] += own[i];
  return all;
}

TEST(CoreShare, CoresThatAllMayUseAreSharedOut) {
  const std::vector<int> node(8, 1);
  EXPECT_EQ(core_share(node, sum({node, node})), 4);
  EXPECT_EQ(core_share(node, sum({node, node, node})), 2);
}

TEST(CoreShare, CoresThatABatchSystemGaveToOneProcessAreItsOwn) {
  const std::vector<int> first{1, 1, 1, 1, 0, 0, 0, 0}, second{0, 0, 0, 0, 1, 1, 1, 1};
  EXPECT_EQ(core_share(first, sum({first, second})), 4);
  EXPECT_EQ(core_share(second, sum({first, second})), 4);
}

TEST(CoreShare, ThirdsAddUpAndNobodyIsLeftWithout) {
  const std::vector<int> three(3, 1);
  EXPECT_EQ(core_share(three, sum({three, three, three})), 1);
  EXPECT_EQ(core_share({1}, sum({{1}, {1}, {1}, {1}})), 1);
}

TEST(CoreShare, AProcessAloneHasTheCoresThatItMayUse) {
  const std::vector<int> own = usable_cores();
  EXPECT_EQ(core_share(own, own), std::accumulate(own.begin(), own.end(), 0));
  EXPECT_EQ(core_share(own, own), thread_count());
}

}  // namespace
}  // namespace isostrata
