#include "data/open/sandbox.h"

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

#include "base/error.h"
#include "base/landlock.h"

namespace isostrata {
namespace {

constexpr const char* kVariable = "ISOSTRATA_SANDBOX";

}  // namespace

const char* to_string(Sandbox sandbox) {
  switch (sandbox) {
    case Sandbox::off:
      return "off";
    case Sandbox::attempt:
      return "try";
    case Sandbox::require:
      break;
  }
  return "require";
}

Sandbox sandbox_of(std::string_view name) {
  for (const Sandbox known : {Sandbox::off, Sandbox::attempt, Sandbox::require})
    if (name == to_string(known)) return known;
  throw Error(ErrorCode::invalid_argument, "'" + std::string(name) + "' is not a sandbox; expected require, try or off");
}

void use_sandbox(std::string_view name) { setenv(kVariable, to_string(sandbox_of(name)), 1); }

bool sandbox_is_chosen() {
  const char* name = std::getenv(kVariable);
  return name && *name;
}

Sandbox sandbox() { return sandbox_is_chosen() ? sandbox_of(std::getenv(kVariable)) : Sandbox::attempt; }

SandboxSupport sandbox_support() {
  SandboxSupport support;
  support.landlock = landlock_version();
  const std::uint32_t action = SECCOMP_RET_ERRNO;
  support.seccomp = syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
  return support;
}

std::string missing_of(const SandboxSupport& support) {
  std::string missing;
  if (support.landlock == 0) missing = "Landlock (Linux 5.13 or newer, switched on), which keeps the reader to its own files";
  if (!support.seccomp)
    missing += std::string(missing.empty() ? "" : ", and ") +
               "seccomp filters, which keep the reader from the network and from "
               "starting programs";
  return missing;
}

}  // namespace isostrata
