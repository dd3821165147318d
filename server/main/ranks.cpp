#include "main/ranks.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "base/program_file.h"
#include "worker/launch_ranks.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

SceneRanks* in_use = nullptr;
std::vector<std::string> command_line;

constexpr int kNotStarted = 127;

std::vector<std::string> without_ranks(const std::vector<std::string>& arguments) {
  std::vector<std::string> rest;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--ranks")
      ++i;
    else if (!arguments[i].starts_with("--ranks="))
      rest.push_back(arguments[i]);
  }
  return rest;
}

/// Starts the words and waits for their end; nothing if they could not be started.
int run_words(std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int failed[2];
  if (pipe2(failed, O_CLOEXEC) != 0) throw_system_error("no pipe can be made", errno);
  const pid_t parent = getpid(), child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(kNotStarted);
    execvp(argv[0], argv.data());
    const int why = errno;
    [[maybe_unused]] const ssize_t told = write(failed[1], &why, sizeof why);
    _exit(kNotStarted);
  }
  const int forked = errno;
  close(failed[1]);
  int why = child < 0 ? forked : 0;
  if (child > 0 && read(failed[0], &why, sizeof why) < 0) why = 0;
  close(failed[0]);
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (why != 0) throw_system_error("--ranks: '" + words[0] + "' cannot be started", why);
  return status;
}

}  // namespace

void use_ranks(SceneRanks* ranks) { in_use = ranks; }
SceneRanks* ranks_in_use() { return in_use; }

void set_command_line(int argc, char** argv) { command_line.assign(argv, argv + argc); }

std::vector<std::string> launcher_words(const std::string& launcher) {
  std::vector<std::string> words = CLI::detail::split_up(launcher);
  for (std::string& word : words) CLI::detail::remove_quotes(word);
  std::erase(words, std::string());
  if (words.empty())
    throw Error(ErrorCode::invalid_argument, "--ranks: expected the command that starts the ranks, such as 'mpirun -n 4'");
  return words;
}

std::string rank_program() {
  const fs::path program = program_file().parent_path() / "isostrata-rank";
  if (access(program.c_str(), X_OK) == 0) return program.string();
  throw Error(ErrorCode::unavailable, "--ranks: " + program.string() +
                                          " is not there: it is built if CMake finds MPI and IceT (`deploy/setup ranks` on Debian; docs/ranks.md)");
}

void add_ranks_option(CLI::App& command, std::string& launcher) {
  if (in_use) return;
  command
      .add_option("--ranks", launcher,
                  "One dataset by many processes: the command that starts them, such as 'mpirun -n 4' or 'srun --mpi=pmix -n 16'. Each "
                  "extracts and draws a region of it (docs/ranks.md)")
      ->type_name("LAUNCHER");
}

void run_by_ranks(const std::string& launcher, const std::string& out) {
  std::vector<std::string> words = launcher_words(launcher);
  words.push_back(rank_program());
  const std::vector<std::string> rest = without_ranks({command_line.begin() + 1, command_line.end()});
  words.insert(words.end(), rest.begin(), rest.end());
  std::error_code ignored;
  const bool one_file = !out.empty() && out.find('%') == std::string::npos;
  const auto before = fs::last_write_time(out, ignored);
  std::fflush(nullptr);
  std::signal(SIGINT, SIG_IGN);  // the launcher ends its ranks, and then this process its wait
  end_job_with_any_rank();
  const int status = run_words(words);
  if (WIFSIGNALED(status))
    throw Error(ErrorCode::unavailable, "--ranks: '" + launcher + "' was ended by signal " + std::to_string(WTERMSIG(status)));
  if (WEXITSTATUS(status) == 0 && one_file && (!fs::exists(out, ignored) || fs::last_write_time(out, ignored) == before))
    throw Error(ErrorCode::unavailable, "--ranks: '" + launcher + "' ended without an error and " + out + " was not written; expected a command that starts the program that follows it");
  std::exit(WEXITSTATUS(status));
}

}  // namespace isostrata
