// Laws of what extract_layers does beyond plain intervals: combined ranges and times between steps.
#pragma once

#include "random/mesh_laws.h"
#include "random/random_grids.h"

namespace isostrata::random_test {

/// A = the input's intervals on its array, B = a range of its second array: what A and B share and what A has alone make up A;
/// A or B exceeds A xor B by what they share; nothing is unmatched. Throws BrokenLaw.
Checked check_combined(const RandomInput& input, Random& random);

/// The strict triangulation: nothing unmatched, the tables' domain facets, the tables' volume where the intervals tile the range,
/// and nothing inverted where all faces are plane. Throws BrokenLaw.
Checked check_strict(const RandomInput& input);

/// The two arrays as two steps of one field: the slices of the space-time volume at a step and between hold what they must: no
/// unmatched facet, and, where the intervals tile the range of both steps in a mesh whose volume is known, all of it. Throws
/// BrokenLaw.
Checked check_space_time(const RandomInput& input, Random& random);

}  // namespace isostrata::random_test
