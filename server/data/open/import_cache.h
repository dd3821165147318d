// What was read from foreign files once, kept between runs: servers and commands of one user share it.
//
// An entry is a folder with the files that the import child wrote (import_door.h), what was measured of them, and, written last, its origin: the
// files that it was read from with their sizes and times, the step, and the reader. A folder without an origin is nobody's and goes. An entry of a
// step that lies on another's mesh has the values alone, and is found by who has that one. An entry is put in place by one rename, so whoever is
// killed leaves nothing half done. After the machine has started anew an entry is checked once more, for what was written shortly before it stopped
// may not be on the disk; and each time on a machine that cannot keep the import child out of the cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "data/dataset/dataset.h"
#include "data/open/import_door.h"

namespace isostrata {

struct ImportCache {
  std::filesystem::path folder;          // made if it is not there, for this user alone
  std::uint64_t max_bytes = 8ull << 30;  // the entries used longest ago make room
  double least_seconds = 0.5;            // what is read faster is not kept
};

/// The one of this process, which open_dataset uses; none at first. Call it once, early, from the main thread.
void set_import_cache(std::optional<ImportCache> cache);
const std::optional<ImportCache>& import_cache();

/// Whether the cache could keep it: not where its file alone takes more than half of the bytes, unless such files can be mapped in place.
bool can_be_cached(const ImportCache& cache, const std::filesystem::path& file);

/// As open_import. Maps the entry if there is one of the files as they are now; else reads them, and keeps what took long enough. A folder that
/// cannot be written is as none. Any thread, any process.
std::shared_ptr<const Dataset> open_import_cached(const std::filesystem::path& file, const ImportOptions& options, const ImportCache& cache,
                                                  const Task& task);

/// Only if there is an entry of the files as they are now; else null.
std::shared_ptr<const Dataset> find_import_cached(const std::filesystem::path& file, const ImportOptions& options, const ImportCache& cache);

/// Something small that was made of a file, kept between the imports and as they are. Any thread, any process. Throws not_found if there is no such file.
class KeptWork {
 public:
  /// Of the file as it is now. `what` says what was made, and by whom.
  KeptWork(const std::filesystem::path& file, std::string what, const ImportCache& cache);
  /// Nothing if it is not there, or is damaged.
  std::optional<std::vector<std::byte>> find() const;
  /// Does nothing if the file has changed since the constructor, and where the machine cannot keep the import child out of the cache.
  void keep(std::span<const std::byte> bytes) const;

 private:
  std::string origin() const;
  const std::filesystem::path file_;
  const std::string what_;
  const ImportCache cache_;
  std::string origin_;
};

struct ImportCacheUse {
  int entries = 0;
  std::uint64_t bytes = 0;
};
ImportCacheUse use_of(const ImportCache& cache);
/// Removes all entries; what is mapped stays with who has it.
void clear(const ImportCache& cache);

}  // namespace isostrata
