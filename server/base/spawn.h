// A child process that no signal of its parent's reaches.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace isostrata {

struct Spawn {
  std::filesystem::path program;
  std::vector<std::string> words;        // its arguments, the first is what it is called
  std::vector<std::string> environment;  // "NAME=VALUE"
  std::vector<int> descriptors;          // [n]: what it finds as its n-th; -1: nothing (/dev/null). It has no others
  /// Who waits for it: the process that starts it, or that one's parent, as for a sibling. The latter from a process of one thread.
  enum class Parent { this_process, parent_of_this } parent = Parent::this_process;
};

/// Starts it in a process group of its own, with no signal blocked or ignored. A program that lies beside this one is started as this one was: by the
/// dynamic loader and its folder of libraries, if that is what was started (base/program_file.h). Returns 0 and its id, or an errno. Any thread.
int spawn_in_group(pid_t& id, const Spawn& spawn);

/// This process's environment but for the variables of these names.
std::vector<std::string> environment_without(const std::vector<std::string>& names);

/// This process becomes that program, found and started as above. arguments: behind its name. Throws unavailable if it cannot be started.
[[noreturn]] void become(const std::filesystem::path& program, std::vector<std::string> arguments);

}  // namespace isostrata
