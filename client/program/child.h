// A program that is started, waited for, and ended with this one.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <optional>
#include <string>
#include <vector>

namespace isostrata::client {

/// Found by $PATH, without standard input; what it says on standard error is said to the user. One thread uses it. Ended, and waited for, if it is destroyed.
class Child {
 public:
  /// captured: out() gives what it writes to standard output, which is the user's otherwise. Throws ClientError "unavailable" if nothing can be started.
  Child(std::vector<std::string> command, bool captured);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// What it has written since the last call, nothing after a fifth of a second without a word; nullopt once it has closed its output.
  std::optional<std::string> part();
  /// All that it writes until it closes its output. Throws ClientError "cancelled" once `stop` is set.
  std::string out(const std::atomic<bool>* stop);
  /// Its exit status, 128 + the signal that ended it, or nothing while it runs; 127: there is no such program.
  std::optional<int> status();
  int wait();
  void end();

 private:
  pid_t pid_ = -1;
  int out_ = -1;
  int status_ = 0;
};

}  // namespace isostrata::client
