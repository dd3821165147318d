// What lies between the values of an array.
#pragma once

namespace isostrata {

enum class FieldValues {
  interpolated,  // values between them: cells are cut
  whole          // nothing: an array of cells has one value in each cell, an array of points that of the nearest point (nearest_points.h)
};

}  // namespace isostrata
