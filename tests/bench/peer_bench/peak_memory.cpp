#include "peak_memory.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "our_extraction.h"
#include "vtk_peer.h"
#include "vtk_threads.h"

namespace isostrata::peers {
namespace {

/// A line of a /proc file in bytes: "VmHWM:    123 kB".
std::uint64_t proc_bytes(const char* file, const std::string& name) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(name + ":")) return std::strtoull(line.c_str() + name.size() + 1, nullptr, 10) * 1024;
  return 0;
}

const char* name_of(Side side) { return side == Side::ours ? "ours" : "vtk"; }

std::string exact(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

[[noreturn]] void become_child(int out, const std::vector<std::string>& words, std::uint64_t max_bytes) {
  rlimit limit{};
  limit.rlim_cur = limit.rlim_max = max_bytes;
  if (max_bytes > 0) setrlimit(RLIMIT_AS, &limit);
  dup2(out, STDOUT_FILENO);
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  execv("/proc/self/exe", argv.data());
  _exit(127);
}

}  // namespace

std::uint64_t machine_memory() { return proc_bytes("/proc/meminfo", "MemTotal"); }

PeakMemory measure_peak_memory(Side side, const std::string& data, const std::string& array, Interval interval, int threads,
                               std::uint64_t max_bytes) {
  const std::string ends = exact(interval.lower) + ":" + exact(interval.upper);
  const std::vector<std::string> words{
      "isostrata-peer-bench", "peak-memory", name_of(side), data, "--array", array, "--interval", ends, "--threads",
      std::to_string(threads)};
  int ends_of_pipe[2];
  if (pipe2(ends_of_pipe, O_CLOEXEC) != 0) throw Error(ErrorCode::unavailable, "no pipe to a child for measuring memory");
  const pid_t child = fork();
  if (child == 0) become_child(ends_of_pipe[1], words, max_bytes);
  close(ends_of_pipe[1]);
  if (child < 0) {
    close(ends_of_pipe[0]);
    throw Error(ErrorCode::unavailable, "no child process for measuring memory");
  }
  std::string text;
  char block[256];
  for (ssize_t got; (got = read(ends_of_pipe[0], block, sizeof block)) > 0;) text.append(block, static_cast<std::size_t>(got));
  close(ends_of_pipe[0]);
  int status = 0;
  waitpid(child, &status, 0);
  PeakMemory memory;
  if (status != 0 || std::sscanf(text.c_str(), "%" SCNu64 " %" SCNu64, &memory.peak_bytes, &memory.data_bytes) != 2)
    throw Error(ErrorCode::unavailable, std::string("measuring the memory of ") + name_of(side) + " on " + data +
                                            ": the child ended with status " + std::to_string(status));
  return memory;
}

void print_peak_memory(Side side, const std::string& data, const std::string& array, Interval interval, int threads) {
  set_thread_count(threads);
  prepare_vtk(threads);
  const Task task;
  Workload workload = open_workload(data, array, task);
  workload.interval = interval;
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak counts from here; where that is refused, from the start
  const std::uint64_t loaded = proc_bytes("/proc/self/status", "VmRSS");
  if (side == Side::ours) {
    const IntervalMesh mesh = extract_ours(workload, task);
    if (mesh.tetrahedra.size() == 0) throw Error(ErrorCode::invalid_argument, data + ": the interval is empty");
  } else {
    VtkPeer peer(workload);
    peer.clip_twice();
    if (peer.cells() == 0) throw Error(ErrorCode::invalid_argument, data + ": the interval is empty");
  }
  std::printf("%" PRIu64 " %" PRIu64 "\n", proc_bytes("/proc/self/status", "VmHWM"), loaded);
}

}  // namespace isostrata::peers
