// Runs something with each level of vector instructions that this machine has.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/simd_level.h"

namespace isostrata::testing {

/// run(level) of each, best first; afterwards the level is the one from before.
template <class Run>
void with_each_simd_level(const Run& run) {
  const std::string before = simd_level();
  for (const std::string& level : simd_levels()) {
    SCOPED_TRACE("SIMD level " + level);
    use_simd_level(level);
    run(level);
  }
  use_simd_level(before);
}

}  // namespace isostrata::testing
