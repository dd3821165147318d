// The datasets that an engine lists, as its works read them: each version of its own, steps shared, with what is known of all steps.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "data/open/import_cache.h"
#include "data/parts/region.h"
#include "data/values/statistics.h"
#include "engine/data/catalogue.h"
#include "engine/data/dataset_facts.h"
#include "engine/data/dataset_store.h"
#include "engine/data/known_ranges.h"
#include "engine/picture/scene_ranks.h"

namespace isostrata {

/// Any thread may call any function; what reads files waits for them. Locks: catalogue_mutex_, views_mutex_, neither while anything is read.
/// Failures name a file as clients know it, never its place. All throw not_found for an id that is not listed, what open_dataset throws, unavailable if
/// the file has changed since it was listed, and cancelled.
class OpenDatasets {
 public:
  /// ranks: as EngineOptions.
  OpenDatasets(Catalogue catalogue, DatasetStoreOptions store, SceneRanks* ranks);

  CatalogueEntry entry(const std::string& id) const;
  /// Lists these, or lists them anew. Returns their ids.
  std::set<std::string> update(std::vector<CatalogueEntry> entries);

  std::shared_ptr<const Dataset> acquire(const CatalogueEntry& of, int step, const Task& task);
  /// acquire() of one dataset; valid as long as this object and `of`.
  StepSource steps(const CatalogueEntry& of);
  /// The same for whoever looks everywhere in this process, also if it has one part of many (Dataset::whole): then all parts are read together, which
  /// nobody keeps.
  StepSource whole_steps(const CatalogueEntry& of);
  /// Whether a step that nobody has asked for may be read ahead.
  bool has_room_for(const std::string& id, int step) const { return store_.has_room_for(id, step); }
  bool holds(const std::string& id, int step) const { return store_.held(id, step) != nullptr; }
  std::uint64_t held_bytes() const { return store_.held_bytes(); }

  struct Glance {
    std::uint64_t max_bytes = 0;
    double timeout_s = 0;
  };
  /// A step for a moment, read by this process alone within these limits, if nobody has it, and kept by nobody. `part`: as DatasetStore::open.
  std::shared_ptr<const Dataset> glance(const CatalogueEntry& of, int step, const Region& part, const Glance& limits, const Task& task) const;
  /// The place for what is made of it in the import cache; nothing if there is none. Reads the beginnings of files.
  static std::optional<KeptWork> kept_work(const CatalogueEntry& of, const std::string& what);

  /// What a client is told of a dataset that it opens: of its first step, and of all steps as far as they are known.
  DatasetFacts describe(const std::string& id, const Task& task);

  struct NextStep {
    int step = 0;
    double known = 0, steps = 1;  // how many there are ranges of, of how many
  };
  /// The first step whose ranges are not known; nothing if all are. Reads the first step if no step has been read.
  std::optional<NextStep> next_unknown(const std::string& id, const Task& task);
  /// Reads a step for its ranges. One that cannot be read is left out of them.
  void read_ranges(const std::string& id, int step, const Task& task);

  /// Of an array of acquire()'s, also if each rank looks at its part of the values.
  std::vector<std::uint64_t> histogram(const std::string& id, const std::shared_ptr<const Dataset>& dataset, const PointArray& array, ValueRange range,
                                       int bins, const Task& task) const;
  Statistics statistics(const std::string& id, const std::shared_ptr<const Dataset>& dataset, const PointArray& array, const Task& task) const;

 private:
  std::shared_ptr<const Dataset> load(const std::string& id, int step, const Task& task, std::shared_ptr<const Dataset> like) const;
  std::shared_ptr<const Dataset> acquire_held(const CatalogueEntry& of, int step, const Task& task);
  void look_for_steps(const CatalogueEntry& of, const Dataset& first_step, const Task& task);
  FirstView view_of_series(const CatalogueEntry& of, const std::shared_ptr<const Dataset>& first_step, const Task& task);
  bool by_ranks(const Dataset& dataset, const PointArray& array) const;
  std::shared_ptr<const Dataset> all_of(const CatalogueEntry& of, std::shared_ptr<const Dataset> dataset, const Task& task) const;

  const DatasetStoreOptions options_;
  SceneRanks* const ranks_;
  mutable std::mutex catalogue_mutex_;  // guards these three
  Catalogue catalogue_;
  std::map<std::string, int> grown_;  // ids of series that have got new steps, and how many parts each has now
  std::map<std::string, int> looked_;  // ids of what was opened of them, and how many of those parts it was looked for
  std::mutex views_mutex_;       // guards this one
  std::map<std::string, std::pair<std::weak_ptr<const Dataset>, FirstView>> views_;  // by id
  KnownRanges ranges_;
  DatasetStore store_;  // last: its threads load by this object
};

}  // namespace isostrata
