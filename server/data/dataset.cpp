#include "data/dataset.h"

#include "data/analytic.h"

namespace isostrata {

const PointArray& Dataset::array(std::string_view wanted) const {
  std::string names;
  for (const PointArray& candidate : arrays) {
    if (candidate.name == wanted) return candidate;
    names += (names.empty() ? "" : ", ") + candidate.name;
  }
  throw Error(ErrorCode::not_found, name + ": no array '" + std::string(wanted) + "'; " +
                                        (names.empty() ? "it has no point or cell arrays" : "it has " + names));
}

}  // namespace isostrata
