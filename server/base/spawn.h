// A child process that no signal of its parent's reaches.
#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <filesystem>

namespace isostrata {

/// posix_spawn into a process group of its own, with no signal blocked or ignored. arguments, environment: as of execve. Returns
/// what posix_spawn does: 0, or an errno. A program that lies beside this one is started as this one was: by the dynamic loader
/// and its folder of libraries, where that is what was started (base/program_file.h). Any thread.
int spawn_in_group(pid_t& id, const std::filesystem::path& program, const posix_spawn_file_actions_t& actions,
                   char* const* arguments, char* const* environment);

}  // namespace isostrata
