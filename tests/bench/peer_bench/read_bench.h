// The rows of `isostrata-peer-bench read`: opening a file by us and by VTK's reader, each time in a process of its own.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace isostrata::peers {

struct ReadBenchOptions {
  std::vector<std::string> files;
  int repeat = 5;  // of each side, in turns; medians are told
  int threads = 2;
};

/// What one way takes, from the file's name to all values with their ranges.
struct ReadCost {
  double ms = 0;
  std::uint64_t held_bytes = 0;  // anonymous memory while the dataset is there; mapped files are the kernel's to take back
  std::uint64_t peak_bytes = 0;  // the largest resident size of a process that took part, mapped files included
};

struct ReadRow {
  std::string file;
  std::uint64_t bytes = 0;
  ReadCost cold, kept, vtk;  // ours with nothing kept, ours once what was read is kept (data/open/import_cache.h), VTK's
};

/// Throws what either side says of the file.
void run_read_bench(const ReadBenchOptions& options, const std::function<void(const ReadRow&)>& row);

/// The child's part: who is "ours" or "vtk". cache: of ours; empty: none. Prints "ms held peak" on standard output.
void print_read_cost(const std::string& who, const std::string& file, const std::string& cache, int threads);

void print_text(const ReadRow& row);

}  // namespace isostrata::peers
