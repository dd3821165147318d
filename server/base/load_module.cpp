#include "base/load_module.h"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "base/program_file.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> places(const char* file, const char* variable) {
  // An empty one means: none, please. The environment is the operator's own, as the program is.
  if (const char* given = std::getenv(variable)) return *given ? std::vector<fs::path>{given} : std::vector<fs::path>{};
  const fs::path folder = program_file().parent_path();
  if (folder.empty()) return {};
  return {folder / file, folder.parent_path() / "lib/isostrata" / file};
}

}  // namespace

LoadedModule load_module(const char* file, const char* variable, const char* function, int version) {
  LoadedModule found;
  found.problem = std::string("no ") + file;
  for (const fs::path& path : places(file, variable)) {
    std::error_code error;
    if (!fs::exists(path, error)) continue;
    found.path = path.string();
    // Never closed: what it returns points into it.
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      const char* why = dlerror();
      found.problem = why ? why : found.path + " cannot be loaded";
      continue;
    }
    const auto function_of_it = reinterpret_cast<const void* (*)()>(dlsym(library, function));
    const void* entry = function_of_it ? function_of_it() : nullptr;
    if (entry && *static_cast<const int*>(entry) == version) return {entry, found.path, {}};
    found.problem = found.path + " is of another version than the program";
  }
  return found;
}

}  // namespace isostrata
