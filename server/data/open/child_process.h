// A child process with a deadline.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/task.h"

namespace isostrata {

struct ChildProgram {
  std::filesystem::path program;
  std::vector<std::string> arguments;                   // no shell sees them
  std::optional<std::vector<std::string>> environment;  // "NAME=VALUE" each; none: this process's
};

struct ChildResult {
  int exit_status = 0;  // where signal is 0
  int signal = 0;       // that ended it
  std::string errors;   // the last 64 KiB of its standard error
};

/// Runs a program, in a process group of its own, without standard input and without the parent's other
/// descriptors, until it ends. Each line of its standard output goes to on_line. Throws cancelled when the task is, bad_data
/// after timeout_s (both end the child's whole group first), unavailable if it cannot be started. Never leaves a zombie. Any
/// thread.
ChildResult run_child(const ChildProgram& child, double timeout_s, const Task& task,
                      const std::function<void(std::string_view line)>& on_line);

/// A process that was started. With its object its whole group ends, and is gone then.
class Child {
 public:
  virtual ~Child() = default;
  /// Whether it is over; `status` is then as of waitpid. Throws unavailable if nobody can say.
  virtual bool ended(int& status) = 0;
};

/// As run_child, of a process that `start` makes: with `out` as its standard output and `err` as its standard error.
using StartChild = std::function<std::unique_ptr<Child>(int out, int err)>;
ChildResult follow_child(const StartChild& start, double timeout_s, const Task& task, const std::function<void(std::string_view line)>& on_line);

}  // namespace isostrata
