#include "peak_memory.h"

#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "our_extraction.h"
#include "run_again.h"
#include "vtk_peer.h"
#include "vtk_threads.h"

namespace isostrata::peers {
namespace {

const char* name_of(Side side) { return side == Side::ours ? "ours" : "vtk"; }

std::string exact(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

}  // namespace

std::uint64_t machine_memory() { return proc_bytes("/proc/meminfo", "MemTotal"); }

PeakMemory measure_peak_memory(Side side, const std::string& data, const std::string& array, Interval interval, int threads,
                               std::uint64_t max_bytes) {
  const std::string ends = exact(interval.lower) + ":" + exact(interval.upper);
  const std::vector<std::string> words{
      "isostrata-peer-bench", "peak-memory", name_of(side), data, "--array", array, "--interval", ends, "--threads",
      std::to_string(threads)};
  const std::string text = run_again(words, max_bytes);
  PeakMemory memory;
  if (std::sscanf(text.c_str(), "%" SCNu64 " %" SCNu64, &memory.peak_bytes, &memory.data_bytes) != 2)
    throw Error(ErrorCode::unavailable, std::string("measuring the memory of ") + name_of(side) + " on " + data + ": the child said '" + text + "'");
  return memory;
}

void print_peak_memory(Side side, const std::string& data, const std::string& array, Interval interval, int threads) {
  set_thread_count(threads);
  prepare_vtk(threads);
  const Task task;
  Workload workload = open_workload(data, array, task);
  workload.interval = interval;
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak counts from here; if that is refused, from the start
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
