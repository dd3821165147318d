#include "base/spawn.h"

#include <fcntl.h>
#include <sched.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <string_view>

#include "base/error.h"
#include "base/program_file.h"

extern char** environ;

namespace isostrata {
namespace {

constexpr const char* kThisProgram = "/proc/self/exe";

/// What is to be executed, and with which words.
struct Command {
  std::string file;
  std::vector<std::string> words;
};

Command command_of(const Spawn& spawn) {
  const std::filesystem::path loader = program_loader();
  if (loader.empty()) return {spawn.program.string(), spawn.words};
  const std::filesystem::path own = spawn.program == kThisProgram ? program_file() : spawn.program;
  if (own.parent_path() != program_file().parent_path()) return {spawn.program.string(), spawn.words};
  Command command{loader.string(), {loader.string(), "--library-path", loader.parent_path().string(), own.string()}};
  command.words.insert(command.words.end(), spawn.words.begin() + 1, spawn.words.end());
  return command;
}

/// As execve wants them: pointers into `words`, and a null.
std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> out;
  for (std::string& word : words) out.push_back(word.data());
  out.push_back(nullptr);
  return out;
}

/// Copies above those that the child finds its own at, so that one dup2 does not close what the next one needs.
class Copies {
 public:
  explicit Copies(const std::vector<int>& descriptors) {
    const int least = std::max<int>(16, static_cast<int>(descriptors.size()));
    for (const int of : descriptors) {
      const int nothing = of < 0 ? open("/dev/null", O_RDWR | O_CLOEXEC) : -1;
      all.push_back(fcntl(of < 0 ? nothing : of, F_DUPFD_CLOEXEC, least));
      if (all.back() < 0) error = errno;
      if (nothing >= 0) close(nothing);
    }
  }
  ~Copies() {
    for (const int copy : all)
      if (copy >= 0) close(copy);
  }
  Copies(const Copies&) = delete;
  Copies& operator=(const Copies&) = delete;

  std::vector<int> all;
  int error = 0;
};

int spawn_child(pid_t& id, const Command& command, char* const* words, char* const* environment, const Copies& copies) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (std::size_t i = 0; i < copies.all.size(); ++i) posix_spawn_file_actions_adddup2(&actions, copies.all[i], static_cast<int>(i));
  posix_spawn_file_actions_addclosefrom_np(&actions, static_cast<int>(copies.all.size()));
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, defaults;
  sigemptyset(&none);
  sigfillset(&defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  const int error = posix_spawn(&id, command.file.c_str(), &actions, &attributes, words, environment);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

/// posix_spawn cannot make a sibling. With one thread there is no lock that another one could hold, so after the fork anything goes.
int spawn_sibling(pid_t& id, const Command& command, char* const* words, char* const* environment, const Copies& copies) {
  int failed[2];
  if (pipe2(failed, O_CLOEXEC) != 0) return errno;
  const long made = syscall(SYS_clone, CLONE_PARENT | SIGCHLD, nullptr, nullptr, nullptr, nullptr);
  if (made == 0) {
    setpgid(0, 0);
    for (int signal = 1; signal < NSIG; ++signal) ::signal(signal, SIG_DFL);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    const int said = fcntl(failed[1], F_DUPFD_CLOEXEC, static_cast<int>(16 + copies.all.size()));
    for (std::size_t i = 0; i < copies.all.size(); ++i) dup2(copies.all[i], static_cast<int>(i));
    syscall(SYS_close_range, static_cast<unsigned>(copies.all.size()), ~0u, 4u);  // on exec
    execve(command.file.c_str(), words, environment);
    const int why = errno;
    [[maybe_unused]] const ssize_t told = write(said, &why, sizeof why);
    _exit(127);
  }
  int error = made < 0 ? errno : 0;
  close(failed[1]);
  if (made > 0 && read(failed[0], &error, sizeof error) != static_cast<ssize_t>(sizeof error)) error = 0;
  close(failed[0]);
  id = static_cast<pid_t>(made);
  return error;
}

}  // namespace

int spawn_in_group(pid_t& id, const Spawn& spawn) {
  Command command = command_of(spawn);
  std::vector<std::string> settings = spawn.environment;
  const Copies copies(spawn.descriptors);
  if (copies.error != 0) return copies.error;
  const auto words = pointers(command.words), environment = pointers(settings);
  const auto start = spawn.parent == Spawn::Parent::this_process ? spawn_child : spawn_sibling;
  return start(id, command, words.data(), environment.data(), copies);
}

std::vector<std::string> environment_without(const std::vector<std::string>& names) {
  std::vector<std::string> kept;
  for (char** of = environ; of && *of; ++of) {
    const std::string_view setting = *of;
    const bool left_out = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return setting.starts_with(name) && setting.substr(name.size()).starts_with('=');
    });
    if (!left_out) kept.emplace_back(setting);
  }
  return kept;
}

void become(const std::filesystem::path& program, std::vector<std::string> arguments) {
  Spawn spawn{program, {program.string()}};
  spawn.words.insert(spawn.words.end(), arguments.begin(), arguments.end());
  Command command = command_of(spawn);
  execv(command.file.c_str(), pointers(command.words).data());
  throw_system_error(program.string() + " cannot be started", errno);
}

}  // namespace isostrata
