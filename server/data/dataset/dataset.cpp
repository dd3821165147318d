#include "data/dataset/dataset.h"

#include <string>
#include <vector>

#include "base/nearest_name.h"

namespace isostrata {

std::shared_ptr<Dataset> described_as(const Dataset& whole) {
  auto out = std::make_shared<Dataset>();
  out->name = whole.name;
  out->bounds = whole.bounds;
  out->axes = whole.axes;
  out->times = whole.times;
  out->step = whole.step;
  out->notes = whole.notes;
  return out;
}

const PointArray& Dataset::array(std::string_view wanted) const {
  std::string all;
  std::vector<std::string> names;
  for (const PointArray& candidate : arrays) {
    if (candidate.name == wanted) return candidate;
    all += (all.empty() ? "" : ", ") + candidate.name;
    names.push_back(candidate.name);
  }
  const std::string meant = did_you_mean(wanted, names);
  throw Error(ErrorCode::not_found, name + ": no array '" + std::string(wanted) + "'; " + (all.empty() ? "it has no point or cell arrays" : "it has " + all) + (meant.empty() ? "" : "." + meant));
}

}  // namespace isostrata
