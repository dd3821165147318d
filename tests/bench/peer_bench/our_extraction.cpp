#include "our_extraction.h"

#include "extraction/intervals/extract_intervals.h"

namespace isostrata::peers {
namespace {

IntervalMesh extract(const Workload& workload, bool measure, OurMemory* memory, const Task& task) {
  ExtractOptions options;
  options.facets = false;
  options.values = false;
  options.measure = measure;
  if (memory) {
    options.bricks = &memory->bricks;
    options.ordered = &memory->ordered;
  }
  return extract_intervals(workload.dataset->grid, workload.values(), {&workload.interval, 1}, options, task);
}

}  // namespace

IntervalMesh extract_ours(const Workload& workload, const Task& task) { return extract(workload, false, nullptr, task); }

IntervalMesh extract_and_measure(const Workload& workload, const Task& task) { return extract(workload, true, nullptr, task); }

IntervalMesh extract_kept(const Workload& workload, OurMemory& memory, const Task& task) {
  return extract(workload, false, &memory, task);
}

}  // namespace isostrata::peers
