// What both sides are given: a dataset and an interval that passes through a stated share of its cells.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata::peers {

struct Workload {
  std::shared_ptr<const Dataset> dataset;
  std::string array;
  Interval interval;

  const PointArray& values() const { return dataset->array(array); }
};

/// As open_dataset, and "torus-u8:N": the distance of torus:N in 8 bits, 0 to 1.5 over 0 to 255. `array` empty: the first.
Workload open_workload(const std::string& data, const std::string& array, const Task& task);

/// The interval of the given half width about `center` in which the values of just `share` of all cells lie or which they cross.
/// Half the width is rounded to four digits, so that it can be named, and is at least a hundredth of the array's range: a coarse
/// grid's cells are cut by the middle alone, and volumes of next to nothing could not be compared. O(cells). Throws
/// invalid_argument (share outside (0, 1], a grid without cells).
Interval interval_through(const Workload& workload, double center, double share);

/// 0.25 for a torus, the field's own value there; else the middle of the array's range.
double usual_center(const std::string& data, const PointArray& array);

}  // namespace isostrata::peers
