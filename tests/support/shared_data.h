// Real datasets that others made; not part of the project and may be absent. Only suites whose names begin with SharedData read them:
// ctest knows these only while the data is there (tests/CMakeLists.txt). The law that a file is an example of is tested elsewhere by a
// file that the test writes itself.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "support/places.h"

namespace isostrata::testing {

/// $ISOSTRATA_TEST_DATA, or ../shared/data beside the project.
inline std::filesystem::path shared_data() {
  const char* given = std::getenv("ISOSTRATA_TEST_DATA");
  return given && *given ? std::filesystem::path(given) : std::filesystem::path(isostrata::places::source()) / ".." / "shared" / "data";
}

/// For who runs the executable by hand.
#define ISOSTRATA_NEEDS_SHARED_DATA()                                              \
  if (!std::filesystem::exists(::isostrata::testing::shared_data() / "README.md")) \
  GTEST_SKIP() << "no test data at " << ::isostrata::testing::shared_data() << "; set ISOSTRATA_TEST_DATA"

}  // namespace isostrata::testing
