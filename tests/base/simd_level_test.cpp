#include "base/simd_level.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "base/error.h"
#include "support/simd_levels.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;

/// Why the level is refused; empty: it is not.
std::string refusal(const std::string& level, ErrorCode code) {
  try {
    use_simd_level(level);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "";
}

TEST(SimdLevel, EachLevelOfTheMachineCanBeUsedAndAutoIsTheBest) {
  const std::vector<std::string> levels = simd_levels();
  ASSERT_FALSE(levels.empty());
  EXPECT_EQ(levels.back(), "emulated") << "what every processor has";
  testing::with_each_simd_level([](const std::string& level) {
    EXPECT_EQ(simd_level(), level);
    EXPECT_STREQ(std::getenv("ISOSTRATA_SIMD"), level.c_str()) << "for the programs that this one starts";
  });
  const std::string before = simd_level();
  use_simd_level("auto");
  EXPECT_EQ(simd_level(), levels.front());
  use_simd_level(before);
}

TEST(SimdLevel, WhatTheMachineDoesNotHaveIsRefusedAndChangesNothing) {
  const std::string before = simd_level();
  const std::vector<std::string> own = simd_levels();
  for (const char* level : {"avx512", "avx2", "sse4", "emulated"})
    if (std::find(own.begin(), own.end(), level) == own.end()) {
      EXPECT_THAT(refusal(level, ErrorCode::unavailable), HasSubstr(std::string(level) + "': this machine does not have it"));
      EXPECT_EQ(simd_level(), before);
    }
  for (const char* name : {"", "AVX2", "avx", "avx-512", "best"}) {
    EXPECT_THAT(refusal(name, ErrorCode::invalid_argument), HasSubstr("expected auto, avx512, avx2, sse4, emulated")) << name;
    EXPECT_EQ(simd_level(), before);
  }
}

TEST(SimdLevel, TheEnvironmentsIsNamedWhereItIsWrong) {
  const std::string before = simd_level();
  setenv("ISOSTRATA_SIMD", "fast", 1);
  try {
    use_simd_level_of_environment();
    ADD_FAILURE() << "taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("ISOSTRATA_SIMD: SIMD level 'fast'"));
  }
  for (const char* nothing : {"", "emulated"}) {
    setenv("ISOSTRATA_SIMD", nothing, 1);
    use_simd_level_of_environment();
  }
  EXPECT_EQ(simd_level(), "emulated");
  use_simd_level(before);
}

}  // namespace
}  // namespace isostrata
