// $ISOSTRATA_SIMD for a test executable, as the programs have it.
#include <gtest/gtest.h>

#include "base/simd_level.h"

namespace {

class SimdEnvironment final : public testing::Environment {
  void SetUp() override { isostrata::use_simd_level_of_environment(); }
};

testing::Environment* const environment = testing::AddGlobalTestEnvironment(new SimdEnvironment);

}  // namespace
