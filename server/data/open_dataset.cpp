#include "data/analytic.h"
#include "data/dataset.h"

namespace isostrata {

std::shared_ptr<const Dataset> open_dataset(std::string_view name, const OpenOptions& options, const Task& task) {
  if (is_analytic(name)) return make_analytic(name, options, task);
  throw Error(ErrorCode::unsupported, std::string(name) + ": only analytic data can be opened");
}

}  // namespace isostrata
