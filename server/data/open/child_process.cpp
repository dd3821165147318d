#include "data/open/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>

#include "base/spawn.h"
#include "base/stopwatch.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostErrors = 64 << 10;
constexpr std::size_t kLongestLine = 4 << 10;

/// Both ends of a pipe, closed on exec.
struct Pipe {
  int read = -1, write = -1;

  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
      throw_system_error("cannot make a pipe", errno);
    read = ends[0];
    write = ends[1];
  }
  ~Pipe() {
    close_end(read);
    close_end(write);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  static void close_end(int& end) {
    if (end >= 0) close(end);
    end = -1;
  }
};

class SpawnedChild final : public Child {
 public:
  explicit SpawnedChild(pid_t id) : id_(id) {}
  ~SpawnedChild() override {
    if (id_ <= 0) return;
    kill(-id_, SIGKILL);
    kill(id_, SIGKILL);
    int status = 0;
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
  }
  SpawnedChild(const SpawnedChild&) = delete;
  SpawnedChild& operator=(const SpawnedChild&) = delete;

  bool ended(int& status) override {
    const pid_t done = waitpid(id_, &status, WNOHANG);
    if (done != id_) return false;
    kill(-id_, SIGKILL);  // what it may have left in its group
    id_ = 0;
    return true;
  }

 private:
  pid_t id_;
};

pid_t start(const ChildProgram& child, int out, int err) {
  Spawn spawn{.program = child.program, .words = {child.program.string()}, .environment = {}, .descriptors = {-1, out, err}};
  spawn.words.insert(spawn.words.end(), child.arguments.begin(), child.arguments.end());
  spawn.environment = child.environment ? *child.environment : environment_without({});
  pid_t id = 0;
  if (const int error = spawn_in_group(id, spawn); error != 0)
    throw_system_error(child.program.string() + ": cannot be started", error);
  return id;
}

/// Passes whole lines on; a line that is too long is cut off.
class Lines {
 public:
  explicit Lines(const std::function<void(std::string_view)>& on_line) : on_line_(on_line) {}
  void add(std::string_view text) {
    for (const char c : text) {
      if (c == '\n') {
        on_line_(line_);
        line_.clear();
      } else if (line_.size() < kLongestLine) {
        line_ += c;
      }
    }
  }

 private:
  const std::function<void(std::string_view)>& on_line_;
  std::string line_;
};

}  // namespace

ChildResult run_child(const ChildProgram& program, double timeout_s, const Task& task,
                      const std::function<void(std::string_view line)>& on_line) {
  return follow_child([&](int out, int err) { return std::make_unique<SpawnedChild>(start(program, out, err)); }, timeout_s, task, on_line);
}

ChildResult follow_child(const StartChild& start, double timeout_s, const Task& task, const std::function<void(std::string_view line)>& on_line) {
  const Stopwatch clock;
  Pipe out, err;
  const std::unique_ptr<Child> child = start(out.write, err.write);
  Pipe::close_end(out.write);
  Pipe::close_end(err.write);

  ChildResult result;
  Lines lines(on_line);
  const auto drain = [](int& end, const auto& use) {
    std::array<char, 8192> buffer;
    const ssize_t got = read(end, buffer.data(), buffer.size());
    if (got > 0)
      use(std::string_view(buffer.data(), static_cast<std::size_t>(got)));
    else if (got == 0 || (errno != EINTR && errno != EAGAIN))
      Pipe::close_end(end);
  };
  const auto keep_errors = [&](std::string_view text) {
    result.errors += text;
    if (result.errors.size() > kMostErrors) result.errors.erase(0, result.errors.size() - kMostErrors);
  };
  int status = 0;
  for (bool ended = false;;) {
    task.check();
    if (clock.elapsed_ms() > 1000 * timeout_s)
      throw Error(ErrorCode::bad_data, "the reader was ended after " + std::to_string(static_cast<long>(timeout_s)) + " s");
    pollfd waits[2] = {{out.read, POLLIN, 0}, {err.read, POLLIN, 0}};  // a negative descriptor is skipped
    const bool open = out.read >= 0 || err.read >= 0;
    const int ready = poll(waits, 2, ended ? 0 : open ? 50 : 5);
    if (waits[0].revents) drain(out.read, [&](std::string_view text) { lines.add(text); });
    if (waits[1].revents) drain(err.read, keep_errors);
    if (ended && (ready <= 0 || !open)) break;  // everything that it wrote has been read
    if (!ended) ended = child->ended(status);
  }
  if (WIFSIGNALED(status))
    result.signal = WTERMSIG(status);
  else
    result.exit_status = WEXITSTATUS(status);
  return result;
}

}  // namespace isostrata
