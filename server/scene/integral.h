// Light along a ray.
#pragma once

namespace isostrata {

/// How light is gathered over a ray's segment in a tetrahedron.
enum class Integral {
  exact,   // Gauss-Legendre points in the segment, or one exponential where colour and extinction are constant
  table2d  // the paper's: a table over length and mean scalar value
};

}  // namespace isostrata
