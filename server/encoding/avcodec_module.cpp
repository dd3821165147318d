#include "encoding/avcodec_module.h"

#include "encoding/load_module.h"

namespace isostrata {
namespace {

AvcodecModule find_module() {
  const LoadedModule found =
      load_module("libisostrata_avcodec.so", "ISOSTRATA_AVCODEC", "isostrata_avcodec_module", ISOSTRATA_AVCODEC_ABI);
  const auto* functions = static_cast<const isostrata_avcodec*>(found.entry);
  if (!functions) return {nullptr, {}, found.problem + (found.path.empty() ? " (built with -DISOSTRATA_AVCODEC=ON)" : "")};
  return {functions, found.path, {}};
}

}  // namespace

const AvcodecModule& avcodec_module() {
  static const AvcodecModule module = find_module();
  return module;
}

}  // namespace isostrata
