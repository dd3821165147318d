// The array that is meant if nobody names one.
#pragma once

#include <string>

#include "data/dataset/dataset.h"

namespace isostrata {

/// The array of this name, or the first one if the name is empty. Throws not_found.
inline const PointArray& array_or_first(const Dataset& dataset, const std::string& name) {
  if (!name.empty()) return dataset.array(name);
  if (dataset.arrays.empty()) throw Error(ErrorCode::not_found, dataset.name + ": it has no array of points or cells; expected at least one");
  return dataset.arrays.front();
}

}  // namespace isostrata
