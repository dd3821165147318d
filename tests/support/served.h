// The real programs: a server that is started, answers and ends with the test, and clients that run beside it.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "support/places.h"
#include "support/run_isostrata.h"
#include "support/temporary_folder.h"

extern char** environ;

namespace isostrata::testing {

/// One process whose output goes to files. Killed where it still runs at the end.
class Process {
 public:
  explicit Process(std::vector<std::string> command) {
    std::vector<char*> argv;
    for (std::string& argument : command) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 1, (folder_ / "out").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&files, 2, (folder_ / "err").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    EXPECT_EQ(posix_spawn(&pid_, argv[0], &files, nullptr, argv.data(), environ), 0) << argv[0];
    posix_spawn_file_actions_destroy(&files);
  }
  ~Process() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Nothing if it has ended: a process id of -1 would mean every process there is.
  void signal(int number) const {
    if (pid_ > 0) ::kill(pid_, number);
  }
  /// Whether it has ended; its status is then there.
  bool ended() {
    if (pid_ > 0 && waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = -1;
    return pid_ <= 0;
  }
  /// The exit status, 128 + the signal that ended it, or -1 if it did not end in two minutes.
  int wait() {
    for (int i = 0; i < 12000 && !ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (pid_ > 0) return -1;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }
  /// Waits until the output has `part`; false if the process ends or half a minute passes without it.
  bool says(const std::string& part) {
    for (int i = 0; i < 3000; ++i) {
      const bool over = ended();
      if (out().find(part) != std::string::npos) return true;
      if (over) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  pid_t pid() const { return pid_; }  // -1 once it has ended
  std::string out() const { return read_text(folder_ / "out"); }
  std::string err() const { return read_text(folder_ / "err"); }

 private:
  TemporaryFolder folder_;
  pid_t pid_ = -1;
  int status_ = 0;
};

struct Ended {
  int status;
  std::string out, err;
};

inline Ended run_to_end(std::vector<std::string> command) {
  Process process(std::move(command));
  const int status = process.wait();
  return {status, process.out(), process.err()};
}

/// A real `isostrata serve` of the build. Where no device of this machine can draw, url() is empty.
class Served {
 public:
  explicit Served(std::vector<std::string> arguments) : arguments_(std::move(arguments)) { start("0"); }

  /// Ends it by the signal, where it runs, and starts it again on the same port. What it is to know again, arguments like
  /// --token-file and --state-dir say.
  void restart(int signal = SIGKILL) {
    stop(signal);
    start(port_);
  }
  int stop(int signal) {
    server_->signal(signal);
    return server_->wait();
  }

  static std::string program(const std::string& name) { return isostrata::places::binaries() + "/" + name; }
  const std::string& url() const { return url_; }
  Process& process() const { return *server_; }
  /// `isostrata-client URL ARGUMENTS`.
  Ended client(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {program("isostrata-client"), url_});
    return run_to_end(std::move(arguments));
  }

 private:
  void start(const std::string& port) {
    std::filesystem::remove(folder_ / "ready");
    std::vector<std::string> command{program("isostrata"), "serve", "--port", port, "--ready-file", (folder_ / "ready").string()};
    command.insert(command.end(), arguments_.begin(), arguments_.end());
    if (std::find(arguments_.begin(), arguments_.end(), "--state-dir") == arguments_.end())
      command.insert(command.end(), {"--state-dir", "none"});  // a test leaves nothing behind
    server_ = std::make_unique<Process>(std::move(command));
    for (int i = 0; i < 6000 && !std::filesystem::exists(folder_ / "ready"); ++i) {
      if (server_->ended()) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    if (!std::filesystem::exists(folder_ / "ready")) return;
    const auto ready = boost::json::parse(read_text(folder_ / "ready"));
    url_ = std::string(ready.at("url").as_string());
    port_ = std::to_string(ready.at("port").to_number<int>());
  }

  const std::vector<std::string> arguments_;
  TemporaryFolder folder_;
  std::unique_ptr<Process> server_;
  std::string url_, port_;
};

#define SERVED_OR_SKIP(server) \
  if (server.url().empty()) GTEST_SKIP() << "isostrata serve does not start here: " << server.process().err()

}  // namespace isostrata::testing
