#include <filesystem>

#include "data/dataset/analytic.h"
#include "data/dataset/dataset.h"
#include "data/open/import_cache.h"
#include "data/open/import_door.h"

namespace isostrata {

std::shared_ptr<const Dataset> open_dataset(std::string_view name, const OpenOptions& options, const Task& task) {
  if (is_analytic(name)) return make_analytic(name, options, task);
  if (import_cache()) return open_import_cached(std::filesystem::path(name), options, *import_cache(), task);
  return open_import(std::filesystem::path(name), options, task);
}

}  // namespace isostrata
