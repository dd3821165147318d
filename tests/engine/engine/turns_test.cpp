#include "engine/engine/turns.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <vector>

namespace isostrata {
namespace {

class TurnsTest : public ::testing::Test {
 protected:
  /// One of what the sessions have left, until there is nothing or so many were taken.
  std::vector<int> drawn(int most = 100) {
    std::vector<int> all;
    while (most-- > 0) {
      const std::optional<int> next = turns_.next(left_, [](std::vector<int>& of) -> std::optional<int> {
        if (of.empty()) return std::nullopt;
        const int first = of.front();
        of.erase(of.begin());
        return first;
      });
      if (!next) break;
      all.push_back(*next);
    }
    return all;
  }
  std::map<SessionKey, std::vector<int>> left_;
  Turns turns_;
};

TEST_F(TurnsTest, EachIsDrawnOnceBeforeAnyIsDrawnTwice) {
  left_ = {{3, {31, 32, 33}}, {5, {51, 52}}, {9, {91, 92, 93, 94}}};
  EXPECT_EQ(drawn(), (std::vector<int>{31, 51, 91, 32, 52, 92, 33, 93, 94}));
  EXPECT_TRUE(drawn().empty());
}

TEST_F(TurnsTest, WhoComesOrHasEndedDisturbsNobodysTurn) {
  left_ = {{3, {31, 32}}, {5, {51, 52}}, {9, {91, 92}}};
  EXPECT_EQ(drawn(2), (std::vector<int>{31, 51}));
  left_.erase(5);
  left_[4] = {41};
  EXPECT_EQ(drawn(), (std::vector<int>{91, 32, 41, 92}));
  left_.clear();
  EXPECT_TRUE(drawn().empty());
}

}  // namespace
}  // namespace isostrata
