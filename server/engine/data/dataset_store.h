// Loaded datasets, shared between sessions. A dataset is loaded once however many ask for it; the least recently used ones that
// nobody holds are dropped when the budget is passed.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "data/dataset/dataset.h"
#include "data/parts/region.h"

namespace isostrata {

struct DatasetStoreOptions {
  std::uint64_t max_bytes = 8ull << 30;  // kept between uses; also the most that one dataset may need
  std::filesystem::path importer;        // as OpenOptions
  double timeout_s = 600;                // as OpenOptions
  std::filesystem::path keep;            // as open_import_keeping; empty: nothing is kept
  bool cache = true;                     // what took long to read is kept in the import cache, if there is one
  Region part;                           // of each structured grid that is opened whole
};

/// Steps of one source that lie on the very same mesh share one copy of it: a step then takes its arrays. Any thread may call any function. Lock:
/// mutex_.
class DatasetStore {
 public:
  /// like: another step of it that is held, or null.
  using Loader = std::function<std::shared_ptr<const Dataset>(const std::string& source, int step, const Task& task, std::shared_ptr<const Dataset> like)>;

  explicit DatasetStore(DatasetStoreOptions options);
  /// What it loads with: open_dataset, keeping what was imported where the options say so. `source` is a path or the name of analytic data.
  /// `part`: of a structured grid, in place of the options' (`unsupported` of others); values beside it are not read if they can be mapped in place.
  /// `like`: as ImportOptions (import_door.h).
  static std::shared_ptr<const Dataset> open(const DatasetStoreOptions& options, const std::string& source, int step, const Task& task,
                                             const Region& part = {}, std::shared_ptr<const Dataset> like = nullptr);
  /// Loads by another function, for which `source` may stand for anything.
  DatasetStore(DatasetStoreOptions options, Loader loader);
  /// Cancels what is loading and waits for it.
  ~DatasetStore();

  /// Waits until the dataset is there, reporting the loading to `task`. Loading ends when everyone who waits for it has
  /// cancelled. Throws what open_dataset throws, and cancelled.
  std::shared_ptr<const Dataset> acquire(const std::string& source, int step, const Task& task);

  /// As acquire, but what is not held is loaded for the caller alone and takes nobody's place.
  std::shared_ptr<const Dataset> borrow(const std::string& source, int step, const Task& task);

  /// What is held; else null.
  std::shared_ptr<const Dataset> held(const std::string& source, int step) const;

  /// Reads it anew the next time, for whoever asks then.
  void drop(const std::string& source, int step);

  /// Whether a step that is neither held nor being loaded would fit beside what is held, half of the budget left: so far a step that nobody has
  /// asked for yet may be loaded. By the steps that are held.
  bool has_room_for(const std::string& source, int step) const;

  std::uint64_t held_bytes() const;

 private:
  struct Loading;
  using Key = std::pair<std::string, int>;
  struct Held {
    std::shared_ptr<const Dataset> dataset;
    std::uint64_t bytes = 0;
    std::uint64_t last_use = 0;
  };

  /// session: whose work it is; nothing if it is nobody's.
  void load(std::shared_ptr<Loading> loading, Key key, std::optional<std::uint64_t> session);
  void drop_unused();  // with mutex_ held

  const DatasetStoreOptions options_;
  const Loader loader_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<Key, Held> held_;
  std::map<Key, std::shared_ptr<Loading>> loading_;
  std::uint64_t uses_ = 0;
  int threads_ = 0;  // that are loading
};

}  // namespace isostrata
