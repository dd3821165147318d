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

/// A bound of what is drawn by triangles. A GPU places and interpolates them with fewer digits than software does: there it may be `factor` times as much.
inline double for_triangles(double bound, double factor) { return test_device().starts_with("egl:") ? factor * bound : bound; }

}  // namespace isostrata::testing
