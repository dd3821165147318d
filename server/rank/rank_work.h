// What every rank does with its own region of a dataset, the first one too: it takes the region's part, extracts, and counts what it owns. No
// MPI here.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "data/derived/scaled_dataset.h"
#include "engine/picture/scene_ranks.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/layers/owned_cells.h"
#include "worker/rank_messages.h"

namespace isostrata {

/// Any thread may call any function. Lock: mutex_.
class RankWork {
 public:
  RankWork(int rank, int count) : rank_(rank), count_(count) {}
  void configure(const RankSetup& setup);

  /// All of a dataset as the setup says that it is read, with nothing looked at that can be mapped (open_unread). Nothing of it is kept. Of one that
  /// lies in as many parts as there are ranks (data/parts/partition.h) it is this rank's part alone, which is then Dataset::whole's.
  StepSource open(const std::string& source) const;
  /// Its part for this rank's region, out of what `whole` opens; kept for the next time, at most max_bytes of parts. Both outlive the call.
  StepSource parts(const std::string& version, const RegionTree& regions, const StepSource& whole);

  /// As extract_scene, with what was kept of extractions before. draws_bricks: of this rank's renderer. made: what this rank counts.
  std::shared_ptr<const ExtractedScene> extract(const RankExtract& order, const StepSource& whole, const std::shared_ptr<const ExtractedScene>& previous,
                                                bool draws_bricks, const Task& task, RankedExtraction& made);
  /// Looks at the values that this rank owns.
  RankMeasured measure(const RankMeasure& order, const StepSource& whole, const Task& task);
  /// What is said of the arrays' ranges in `whole` is said of the part, too, if there is one.
  void know_ranges(const std::string& version, const Dataset& whole);
  /// Extracts, and writes this rank's piece where the order names a file.
  RankedExtraction write(const RankWrite& order, const StepSource& whole, const Task& task);

 private:
  struct Part {
    std::mutex making;
    std::shared_ptr<const Dataset> dataset;
    std::uint64_t bytes = 0, last_use = 0;
  };
  void drop_unused();

  const int rank_, count_;
  std::mutex mutex_;
  DatasetStoreOptions store_;
  Region region_;
  std::map<std::pair<std::string, int>, std::shared_ptr<Part>> parts_;  // by version and step
  std::uint64_t uses_ = 0;
  BrickMemory bricks_;
  ScaledDatasets scaled_;
};

/// "mesh_3.vtu" of "mesh.pvtu": beside it.
std::string piece_path(const std::string& path, int rank);

/// Adds up what ranks have made, one after the other.
void add(RankedExtraction& sum, const RankedExtraction& of);
void add(RankMeasured& sum, const RankMeasured& of);

}  // namespace isostrata
