// How strictly the import child is shut in, and what of that this machine can do.
#pragma once

#include <string>
#include <string_view>

namespace isostrata {

/// attempt: whatever the kernel can do. require: no foreign file is read where the kernel cannot do all of it. off: limits of
/// memory and time alone.
enum class Sandbox { off, attempt, require };

/// "off", "try", "require".
const char* to_string(Sandbox sandbox);
/// Throws invalid_argument for another name.
Sandbox sandbox_of(std::string_view name);

/// Of this process and, by ISOSTRATA_SANDBOX, of the programs that it starts. Before threads are started. Throws invalid_argument
/// for another name.
void use_sandbox(std::string_view name);

/// Whether it was called, or $ISOSTRATA_SANDBOX is set.
bool sandbox_is_chosen();
/// What was chosen, here or in the process that started this one; else attempt.
Sandbox sandbox();

/// What the kernel offers to a process that has no rights.
struct SandboxSupport {
  int landlock = 0;  // the version of its interface; 0: none (before Linux 5.13, or switched off)
  bool seccomp = false;
};
SandboxSupport sandbox_support();

/// What is missing, for a person: "Landlock (Linux 5.13 or newer), which ..."; empty if nothing is.
std::string missing_of(const SandboxSupport& support);

}  // namespace isostrata
