#include "read_bench.h"

#include <sys/resource.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <filesystem>

#include "base/error.h"
#include "base/parallel.h"
#include "base/stopwatch.h"
#include "base/temporary_directory.h"
#include "data/dataset/dataset.h"
#include "data/open/import_cache.h"
#include "run_again.h"
#include "vtk_read.h"
#include "vtk_threads.h"

namespace isostrata::peers {
namespace {

namespace fs = std::filesystem;

ReadCost measure(const std::string& who, const std::string& file, const std::string& cache, int threads) {
  std::vector<std::string> words{"isostrata-peer-bench", "read-once", who, file, "--threads", std::to_string(threads)};
  if (!cache.empty()) words.insert(words.end(), {"--cache", cache});
  const std::string text = run_again(words);
  ReadCost cost;
  if (std::sscanf(text.c_str(), "%lf %" SCNu64 " %" SCNu64, &cost.ms, &cost.held_bytes, &cost.peak_bytes) != 3)
    throw Error(ErrorCode::unavailable, file + ": the child that read it by " + who + " said '" + text + "'");
  return cost;
}

ReadCost median(std::vector<ReadCost> costs) {
  const auto middle = costs.begin() + static_cast<std::ptrdiff_t>(costs.size() / 2);
  std::nth_element(costs.begin(), middle, costs.end(), [](const ReadCost& a, const ReadCost& b) { return a.ms < b.ms; });
  return *middle;
}

double megabytes(std::uint64_t bytes) { return static_cast<double>(bytes) / 1e6; }

}  // namespace

void print_read_cost(const std::string& who, const std::string& file, const std::string& cache, int threads) {
  set_thread_count(threads);
  prepare_vtk(threads);
  if (!cache.empty()) {
    ImportCache keep;
    keep.folder = cache;
    keep.max_bytes = std::uint64_t{1} << 40;
    keep.least_seconds = 0;
    set_import_cache(keep);
  }
  const Stopwatch watch;
  std::shared_ptr<const void> alive;
  if (who == "ours")
    alive = open_dataset(file, {}, Task{});
  else
    alive = read_by_vtk(file);
  const double ms = watch.elapsed_ms();
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  const std::uint64_t own = proc_bytes("/proc/self/status", "VmHWM"), others = static_cast<std::uint64_t>(children.ru_maxrss) * 1024;
  std::printf("%.3f %" PRIu64 " %" PRIu64 "\n", ms, proc_bytes("/proc/self/status", "RssAnon"), std::max(own, others));
}

void run_read_bench(const ReadBenchOptions& options, const std::function<void(const ReadRow&)>& row) {
  for (const std::string& file : options.files) {
    ReadRow of;
    of.file = file;
    of.bytes = fs::file_size(file);
    std::vector<ReadCost> cold, kept, vtk;
    for (int i = 0; i < options.repeat; ++i) {
      const TemporaryDirectory cache(temporary_base(), "isostrata-bench-");
      vtk.push_back(measure("vtk", file, "", options.threads));
      cold.push_back(measure("ours", file, cache.path().string(), options.threads));
      kept.push_back(measure("ours", file, cache.path().string(), options.threads));
    }
    of.cold = median(std::move(cold));
    of.kept = median(std::move(kept));
    of.vtk = median(std::move(vtk));
    row(of);
  }
}

void print_text(const ReadRow& row) {
  std::printf("%s, %.1f MB\n", fs::path(row.file).filename().c_str(), megabytes(row.bytes));
  const auto line = [&](const char* who, const ReadCost& cost) {
    std::printf("  %-24s %9.1f ms, holds %7.1f MB, at most %7.1f MB", who, cost.ms, megabytes(cost.held_bytes), megabytes(cost.peak_bytes));
  };
  line("VTK's reader", row.vtk);
  const auto ours = [&](const char* who, const ReadCost& cost) {
    std::printf("\n");
    line(who, cost);
    std::printf("; by VTK's: time %.2f, held %.2f, at most %.2f", cost.ms / row.vtk.ms, static_cast<double>(cost.held_bytes) / static_cast<double>(row.vtk.held_bytes),
                static_cast<double>(cost.peak_bytes) / static_cast<double>(row.vtk.peak_bytes));
  };
  ours("ours, nothing kept", row.cold);
  ours("ours, kept", row.kept);
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace isostrata::peers
