#include "base/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>

namespace isostrata {
namespace {

using ::testing::HasSubstr;

std::string failure_of(auto&& statement) {
  try {
    statement();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::internal);
    return error.what();
  }
  return "";
}

TEST(Check, SaysNothingOfWhatHolds) {
  const std::size_t points = 12;
  EXPECT_EQ(failure_of([&] {
              ISOSTRATA_CHECK(points == 3u * 4u);
              ISOSTRATA_CHECK(points <= 12u);
              ISOSTRATA_CHECK(points < 13u);
            }),
            "");
}

TEST(Check, AFailureNamesThePlaceTheWordsAndBothValues) {
  const std::size_t points = 11, weights = 12;
  EXPECT_THAT(failure_of([&] { ISOSTRATA_CHECK(points == weights); }),
              testing::MatchesRegex("check_test.cpp:[0-9]+: expected points == weights, but 11 and 12"));
  EXPECT_THAT(failure_of([&] { ISOSTRATA_CHECK(weights <= points); }), HasSubstr("expected weights <= points, but 12 and 11"));
  EXPECT_THAT(failure_of([&] { ISOSTRATA_CHECK(points < points); }), HasSubstr("but 11 and 11"));
}

}  // namespace
}  // namespace isostrata
