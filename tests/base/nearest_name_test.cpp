#include "base/nearest_name.h"

#include <gtest/gtest.h>

#include <vector>

namespace isostrata {
namespace {

TEST(NearestName, IsTheOneThatTakesTheFewestEdits) {
  const std::vector<std::string> names{"render", "extract", "info", "serve", "first-view"};
  EXPECT_EQ(did_you_mean("rendr", names), " Did you mean 'render'?");    // one left out
  EXPECT_EQ(did_you_mean("renderr", names), " Did you mean 'render'?");  // one too many
  EXPECT_EQ(did_you_mean("rander", names), " Did you mean 'render'?");   // another
  EXPECT_EQ(did_you_mean("redner", names), " Did you mean 'render'?");   // exchanged
  EXPECT_EQ(did_you_mean("INFO", names), " Did you mean 'info'?");
  EXPECT_EQ(did_you_mean("firstview", names), " Did you mean 'first-view'?");
}

TEST(NearestName, IsNoneIfNothingIsNear) {
  const std::vector<std::string> names{"render", "extract"};
  EXPECT_EQ(did_you_mean("paint", names), "");
  EXPECT_EQ(did_you_mean("x", names), "");
  EXPECT_EQ(did_you_mean("", names), "");
  EXPECT_EQ(did_you_mean("render", {}), "");
  EXPECT_EQ(did_you_mean(std::string(1000, 'r'), names), "");
}

TEST(NearestName, OfALetterOrTwoIsOneEditAway) {
  const std::vector<std::string> names{"p", "T", "rho"};
  EXPECT_EQ(did_you_mean("t", names), " Did you mean 'T'?");
  EXPECT_EQ(did_you_mean("rh", names), " Did you mean 'rho'?");
  EXPECT_EQ(did_you_mean("density", names), "");
}

}  // namespace
}  // namespace isostrata
