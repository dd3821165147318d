#include "base/spawn.h"

#include <csignal>
#include <string>
#include <vector>

#include "base/program_file.h"

namespace isostrata {
namespace {

constexpr const char* kThisProgram = "/proc/self/exe";

/// What is to be executed, and with which words.
struct Command {
  std::string file;
  std::vector<std::string> first_words;  // in place of the first of the arguments; none: they stay as they are
};

Command command_of(const std::filesystem::path& program) {
  const std::filesystem::path loader = program_loader();
  if (loader.empty()) return {program.string(), {}};
  const std::filesystem::path own = program == kThisProgram ? program_file() : program;
  if (own.parent_path() != program_file().parent_path()) return {program.string(), {}};
  return {loader.string(), {loader.string(), "--library-path", loader.parent_path().string(), own.string()}};
}

}  // namespace

int spawn_in_group(pid_t& id, const std::filesystem::path& program, const posix_spawn_file_actions_t& actions,
                   char* const* arguments, char* const* environment) {
  Command command = command_of(program);
  std::vector<char*> words;
  for (std::string& word : command.first_words) words.push_back(word.data());
  if (!words.empty()) {
    for (char* const* more = arguments + 1; *more; ++more) words.push_back(*more);
    words.push_back(nullptr);
    arguments = words.data();
  }
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, defaults;
  sigemptyset(&none);
  sigfillset(&defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  const int error = posix_spawn(&id, command.file.c_str(), &actions, &attributes, arguments, environment);
  posix_spawnattr_destroy(&attributes);
  return error;
}

}  // namespace isostrata
