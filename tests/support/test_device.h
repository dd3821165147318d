// The device that the tests of OpenGL draw on.
#pragma once

#include <cstdlib>
#include <string>

namespace isostrata::testing {

/// $ISOSTRATA_TEST_DEVICE as make_renderer takes it ("egl:0" on a machine with a GPU), by default the software device, which every
/// machine that runs the tests has.
inline std::string test_device() {
  const char* named = std::getenv("ISOSTRATA_TEST_DEVICE");
  return named && *named ? named : "surfaceless";
}

}  // namespace isostrata::testing
