// The import child takes its own rights away before it looks at a foreign file. SECURITY.md has the table of what is left.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "data/open/sandbox.h"

namespace isostrata {

struct Confinement {
  std::filesystem::path directory;  // may be read, at any depth, but for what is hidden in it and links out of it
  std::filesystem::path file;       // may be read, also if it is a link out of the directory; not one out of its ROOT (data/files/beneath.h)
  std::vector<std::filesystem::path> beside{};  // files that may be read as well, if they are not links
  std::filesystem::path output;     // may be read, and files may be made, written, cut and removed in it
  std::uint64_t memory_bytes = 0;   // of address space; also the largest file that may be written
  std::uint64_t cpu_seconds = 0;
  Sandbox sandbox = Sandbox::attempt;
};

/// Limits first; then Landlock, with every right that this kernel knows, refuses all paths but those above; then seccomp refuses
/// every system call that is not on a list of those that readers use. No process can be made, no program started, no socket and
/// no ring of io_uring opened, no signal sent to another process, no memory made executable; new threads can be started. Of
/// root's rights only that to read files is kept. Without Landlock the same paths are kept to by name (opened_paths.h). Throws
/// unavailable if all of it is required and something is missing. Before there are threads.
void confine(const Confinement& confinement);

}  // namespace isostrata
