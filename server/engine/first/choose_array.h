// Which array of a file nobody has looked at yet is the one to show.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "data/dataset/dataset.h"

namespace isostrata {

struct ArrayChoice {
  std::string name;
  double score = 0;
  std::string reason;
};

/// Best first; those that are never shown unless they are alone (flags, ids, ghosts, coordinates, errors, a few whole numbers)
/// come last, those that are constant in all of `steps`, or have no finite value, not at all. A quantity that people look at
/// first (stress, density, temperature, speed, ...) comes before others, a magnitude before its components, points before cells,
/// and what varies before what hardly does. `steps` are some of one dataset, the shown one first.
std::vector<ArrayChoice> rank_arrays(std::span<const Dataset* const> steps);

/// What a program that computed a constant may be off by, in shares of it.
double rounding_of(ScalarType type);
/// Whether a range is of more than one value, whatever was rounded.
bool varies(double lower, double upper, ScalarType type);
/// Whether the name says a length of a vector for which zero is rest: speed, displacement, momentum.
bool rests_at_zero(const PointArray& array);
/// Whether the name says what a solid's own outline belongs to: stress, strain, displacement.
bool belongs_to_a_solid(std::string_view name);
/// Whether the name says a signed distance, whose zero is a surface.
bool is_level_set(std::string_view name);

}  // namespace isostrata
