#include "base/simd_level.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <hwy/highway.h>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr const char* kVariable = "ISOSTRATA_SIMD";
constexpr const char* kNames[] = {"avx512", "avx2", "sse4", "emulated"};

constexpr std::int64_t kEmulated = HWY_SCALAR | HWY_EMU128;

/// The name of the best of these targets (the lower a bit, the better). Highway has several for one name.
std::string name_of(std::int64_t targets) {
  const std::int64_t best = targets & -targets;
#if HWY_ARCH_X86
  if (best < HWY_AVX2) return "avx512";
  if (best == HWY_AVX2) return "avx2";
  if (best <= HWY_SSSE3) return "sse4";
  return "emulated";  // with SSE2, which the compiler uses by itself, or without
#else
  if (best & kEmulated) return "emulated";
  std::string name = hwy::TargetName(best);
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
#endif
}

/// What the processor has of what is compiled, whatever was asked for.
std::int64_t own_targets() {
  static const std::int64_t targets = [] {
    hwy::SetSupportedTargetsForTest(0);
    return (hwy::SupportedTargets() | kEmulated) & HWY_TARGETS;
  }();
  return targets;
}

/// The best target of that level and all worse ones; 0: there is none.
std::int64_t targets_of(std::string_view level) {
  for (std::int64_t targets = own_targets(); targets != 0; targets &= targets - 1)
    if (name_of(targets) == level) return targets;
  return 0;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

std::vector<std::string> simd_levels() {
  std::vector<std::string> levels;
  for (std::int64_t targets = own_targets(); targets != 0; targets &= targets - 1)
    if (levels.empty() || levels.back() != name_of(targets)) levels.push_back(name_of(targets));
  return levels;
}

std::string simd_level() { return name_of((own_targets() & hwy::SupportedTargets()) | (own_targets() & kEmulated)); }

void use_simd_level(std::string_view name) {
  const std::vector<std::string> own = simd_levels();
  const std::string asked(name);
  if (asked != "auto" && std::find(own.begin(), own.end(), asked) == own.end()) {
    if (std::find(std::begin(kNames), std::end(kNames), asked) == std::end(kNames))
      throw Error(ErrorCode::invalid_argument,
                  "SIMD level '" + asked + "': expected auto, " + listed({std::begin(kNames), std::end(kNames)}));
    throw Error(ErrorCode::unavailable, "SIMD level '" + asked + "': this machine does not have it; it has " + listed(own));
  }
  hwy::SetSupportedTargetsForTest(asked == "auto" ? 0 : targets_of(asked));
  setenv(kVariable, asked.c_str(), 1);
}

void use_simd_level_of_environment() {
  const char* const name = std::getenv(kVariable);
  if (name == nullptr || *name == 0) return;
  try {
    use_simd_level(std::string(name));
  } catch (const Error& error) {
    throw Error(error.code(), std::string(kVariable) + ": " + error.what());
  }
}

}  // namespace isostrata
