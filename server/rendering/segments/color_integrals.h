// A colour map's antiderivatives, so that a ray's segment over any part of it takes two lookups, at its ends.
//
// Along a segment of constant extinction the colour c(p), p the place in the map, runs linearly from p_in to p_out, and its light
// is the opacity times the mean of c weighted by exp(-depth). Up to an optical depth of 1/2 that weight is a line within 2e-2 of
// its mean in the worst place and without error in mean and centre of gravity, so that mean is
//   (G(p_out) - G(p_in)) / (p_out - p_in)  and the like for the weight's slope, with G0 = integral of c, G1 = integral of p c:
// what the map does in between does not matter. Deeper segments are cut into parts.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scene/style.h"

namespace isostrata {

/// Polynomials on up to 16 equal pieces of the map, which vectors look up in registers. In p = pieces * u, u in [0, 1].
struct ColorIntegrals {
  static constexpr int kMostPieces = 16;
  // Of piece k: coefficient of x^i, x = p - k. g1 is the integral of (p - pieces / 2) c.
  alignas(64) float g0[3][5][kMostPieces];
  alignas(64) float g1[3][6][kMostPieces];
  float pieces = 1;

  // The same as a table, for vectors whose registers hold no sixteen numbers: the integrals of red, green, blue and -1 up to node
  // i are nodes[i + kMargin], in steps of 1 / kSteps of the map. Between two nodes a colour is constant.
  static constexpr int kSteps = 1024, kMargin = 8;
  alignas(64) float nodes[kSteps + 2 * kMargin + 1][4];
  // The same with what is between the nodes: sum and colour of red, of green, of blue, and of -1.
  alignas(64) float pairs[kSteps + 2 * kMargin][8];
  // How far, at most, the first moment of the colour over a part of the map, seen from its middle, is from a twelfth of the
  // difference of the colours at its ends; per width of the part.
  float bend = 0;
};

/// How far cubics may be from the map, in display values of [0, 1].
inline constexpr float kPieceError = 1e-3f;

/// Null if no 16 equal cubics follow the map.
std::shared_ptr<const ColorIntegrals> make_color_integrals(const ColorMap& map);

/// Remembers what was made of the maps seen last. One caller at a time.
class ColorIntegralMemory {
 public:
  std::shared_ptr<const ColorIntegrals> of(const ColorMap& map);

 private:
  struct Known {
    std::string name;  // of a map: it says all of it
    std::shared_ptr<const ColorIntegrals> integrals;
  };
  std::vector<Known> known_;  // the one used last is last
};

}  // namespace isostrata
