#include "encoding/avcodec_module.h"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>
#include <vector>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "libisostrata_avcodec.so";

std::vector<fs::path> places() {
  // An empty one means: none, please. The environment is the operator's own, as the program is.
  if (const char* given = std::getenv("ISOSTRATA_AVCODEC"))
    return *given ? std::vector<fs::path>{given} : std::vector<fs::path>{};
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (error) return {};
  return {folder / kFile, folder.parent_path() / "lib" / kFile};
}

AvcodecModule find_module() {
  AvcodecModule found;
  found.problem = std::string("no ") + kFile + " (built with -DISOSTRATA_AVCODEC=ON)";
  for (const fs::path& path : places()) {
    std::error_code error;
    if (!fs::exists(path, error)) continue;
    // Never closed: what it returns points into it.
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      const char* why = dlerror();
      found.problem = why ? why : path.string() + " cannot be loaded";
      continue;
    }
    const auto entry = reinterpret_cast<decltype(&isostrata_avcodec_module)>(dlsym(library, "isostrata_avcodec_module"));
    const isostrata_avcodec* functions = entry ? entry() : nullptr;
    if (!functions || functions->abi != ISOSTRATA_AVCODEC_ABI) {
      found.problem = path.string() + " is of another version than the program";
      continue;
    }
    return {functions, path.string(), {}};
  }
  return found;
}

}  // namespace

const AvcodecModule& avcodec_module() {
  static const AvcodecModule module = find_module();
  return module;
}

}  // namespace isostrata
