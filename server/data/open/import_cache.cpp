#include "data/open/import_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <boost/json.hpp>
#include <cerrno>
#include <ctime>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "base/temporary_directory.h"
#include "data/files/file_series.h"
#include "data/files/recognise.h"
#include "data/files/source_files.h"
#include "data/open/import_door.h"
#include "data/open/sandbox.h"
#include "data/values/kept_facts.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr const char* kMeasures = "measures.json";
constexpr const char* kWork = "work.bin";
constexpr const char* kEntry = "read-";
constexpr const char* kNew = "new-";
constexpr int kLessWithoutGrid = 10;  // values that were found in a large file, beside its mesh, take next to no room
constexpr int kVersion = 6;  // of what an entry looks like, and of what is made of a file

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string boot_id() { return text_of("/proc/sys/kernel/random/boot_id"); }

/// Numbers as their bits: nothing is rounded, and infinite ends of empty ranges are not numbers of JSON.
json::value bits(double value) { return std::bit_cast<std::int64_t>(value); }
double number(const json::value& value) { return std::bit_cast<double>(value.as_int64()); }

std::string to_text(const ImportMeasures& measures) {
  json::array arrays, cells, bounds;
  for (const auto& range : measures.arrays) arrays.push_back(json::array{bits(range.lower), bits(range.upper), range.nan_count});
  for (const auto& range : measures.cells) cells.push_back(json::array{bits(range.lower), bits(range.upper), range.nan_count});
  for (const Vec3d& corner : {measures.bounds.lower, measures.bounds.upper})
    for (int a = 0; a < 3; ++a) bounds.push_back(bits(corner[a]));
  json::object types;
  for (const auto& [name, count] : measures.cell_types) types[name] = count;
  return json::serialize(json::object{{"arrays", arrays}, {"cells", cells}, {"bounds", bounds}, {"cell_types", types}, {"boot", boot_id()}});
}

struct KnownMeasures {
  ImportMeasures measures;
  bool of_this_boot = false;
};

std::optional<KnownMeasures> read_measures(const fs::path& file) {
  try {
    const json::value document = json::parse(text_of(file));
    KnownMeasures known;
    for (const auto& [name, ranges] : {std::pair{"arrays", &known.measures.arrays}, std::pair{"cells", &known.measures.cells}})
      for (const json::value& range : document.at(name).as_array())
        ranges->push_back({number(range.at(0)), number(range.at(1)), range.at(2).as_int64()});
    const json::array& bounds = document.at("bounds").as_array();
    for (int a = 0; a < 3; ++a) {
      known.measures.bounds.lower[a] = number(bounds.at(static_cast<std::size_t>(a)));
      known.measures.bounds.upper[a] = number(bounds.at(static_cast<std::size_t>(a) + 3));
    }
    for (const auto& [name, count] : document.at("cell_types").as_object()) known.measures.cell_types[name] = count.as_int64();
    known.of_this_boot = document.at("boot").as_string() == boot_id();
    return known;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

/// What an entry with a grid of its own was made of, and by which reader; nothing if that cannot be told.
std::optional<std::string> origin_of(const fs::path& file, const ImportOptions& options) {
  const auto files = source_files(file);
  if (!files) return std::nullopt;
  const fs::path reader = options.importer.empty() ? default_importer(options.needs ? options.needs->all_readers : reader_needs(file).all_readers) : options.importer;
  const SourceStamp stamp = stamp_of(reader);
  return std::to_string(kVersion) + ' ' + std::to_string(stamp.bytes) + ' ' + std::to_string(stamp.changed) + "\nstep " +
         std::to_string(options.step) + '\n' + fs::absolute(file).string() + '\n' + *files;
}

/// Of an entry that has no grid: that of step LIKE is its own, as long as these are the files.
std::string origin_beside(const std::string& origin, const Dataset& like) { return origin + "like " + std::to_string(like.step) + '\n'; }

fs::path place_of(const ImportCache& cache, const std::string& origin) {
  return cache.folder / (kEntry + std::to_string(std::hash<std::string>{}(origin)));
}

std::uint64_t bytes_in(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const auto size = fs::file_size(it->path(), error);
    if (!error) bytes += size;
    error.clear();
  }
  return bytes;
}

std::vector<fs::path> folders(const ImportCache& cache, const char* prefix) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(cache.folder, error), end; !error && it != end; it.increment(error))
    if (it->path().filename().string().starts_with(prefix)) found.push_back(it->path());
  return found;
}

void remove_entry(const fs::path& entry) {
  std::error_code ignored;
  fs::remove(entry / kOriginFile, ignored);  // first: from now on it is none
  fs::remove_all(entry, ignored);
}

/// A folder that is being written: a lock on it says that its writer lives.
class NewFolder {
 public:
  explicit NewFolder(const ImportCache& cache) : folder_(cache.folder, kNew), lock_(open(folder_.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (lock_ >= 0) flock(lock_, LOCK_EX | LOCK_NB);
  }
  ~NewFolder() {
    if (lock_ >= 0) close(lock_);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  const fs::path& path() const { return folder_.path(); }
  /// It stays under this name, unless there is one.
  void become(const fs::path& place) {
    std::error_code error;
    fs::rename(folder_.path(), place, error);
  }

 private:
  TemporaryDirectory folder_;
  int lock_;
};

/// What writers that were killed have left.
void sweep(const ImportCache& cache) {
  for (const fs::path& folder : folders(cache, kNew)) {
    const int lock = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock < 0) continue;
    struct stat status {};
    const bool settled = fstat(lock, &status) == 0 && time(nullptr) - status.st_mtime > 60;  // a new one may not have its lock yet
    std::error_code ignored;
    if (settled && flock(lock, LOCK_EX | LOCK_NB) == 0) fs::remove_all(folder, ignored);
    close(lock);
  }
}

void make_room(const ImportCache& cache, std::uint64_t bytes) {
  struct Entry {
    fs::file_time_type used;
    fs::path path;
    std::uint64_t bytes;
  };
  std::vector<Entry> entries;
  std::uint64_t total = bytes;
  for (const fs::path& path : folders(cache, kEntry)) {
    std::error_code error;
    const auto used = fs::last_write_time(path / kOriginFile, error);
    if (error) {
      remove_entry(path);
      continue;
    }
    entries.push_back({used, path, bytes_in(path)});
    total += entries.back().bytes;
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : entries) {
    if (total <= cache.max_bytes) return;
    remove_entry(entry.path);
    total -= entry.bytes;
  }
}

/// Whether a reader that a hostile file has taken over could not have written into the cache: then what lies there is ours.
bool is_shut_in() { return sandbox() != Sandbox::off && sandbox_support().landlock > 0; }

/// What is found out about the arrays from now on is kept in the entry, and what was before is there.
void place_facts(const Dataset& dataset, const fs::path& entry) {
  for (std::size_t i = 0; i < dataset.arrays.size(); ++i)
    set_place_of_facts(dataset.arrays[i].storage, entry, "array_" + std::to_string(i) + ".");
}

std::shared_ptr<const Dataset> find(const fs::path& entry, const std::string& origin, const fs::path& file, const ImportOptions& options) {
  if (text_of(entry / kOriginFile) != origin) return nullptr;
  const auto known = read_measures(entry / kMeasures);
  if (!known) return nullptr;
  std::shared_ptr<const Dataset> dataset;
  try {
    dataset = map_import(entry, file, options, ImportFiles::left, known->of_this_boot && is_shut_in() ? &known->measures : nullptr);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::bad_data) throw;
    remove_entry(entry);  // damaged, or somebody is removing it
    return nullptr;
  }
  if (!known->of_this_boot) {
    const std::string measured = to_text(measures_of(*dataset));
    if (to_text(known->measures) != measured) {
      remove_entry(entry);
      return nullptr;
    }
    std::ofstream(entry / kMeasures, std::ios::binary) << measured;
  }
  std::error_code ignored;
  fs::last_write_time(entry / kOriginFile, fs::file_time_type::clock::now(), ignored);
  if (is_shut_in()) place_facts(*dataset, entry);
  return dataset;
}

/// With a grid of its own, or on that of options.like.
std::shared_ptr<const Dataset> find_either(const ImportCache& cache, const std::string& origin, const fs::path& file, const ImportOptions& options) {
  auto own = find(place_of(cache, origin), origin, file, options);
  if (own || !options.like) return own;
  const std::string beside = origin_beside(origin, *options.like);
  return find(place_of(cache, beside), beside, file, options);
}

bool prepare(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder.parent_path(), error);
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return false;
  struct stat status {};
  // What lies in it is believed, so it must be ours, and no one else's to write.
  return lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid() && (status.st_mode & 022) == 0;
}

std::optional<ImportCache>& of_this_process() {
  static std::optional<ImportCache> cache;
  return cache;
}

}  // namespace

void set_import_cache(std::optional<ImportCache> cache) { of_this_process() = std::move(cache); }
const std::optional<ImportCache>& import_cache() { return of_this_process(); }

bool can_be_cached(const ImportCache& cache, const fs::path& file) {
  // What is mapped in place takes next to nothing in the cache.
  return may_lie_in_place(file) || stamp_of(file).bytes <= cache.max_bytes / 2;
}

std::shared_ptr<const Dataset> find_import_cached(const fs::path& file, const ImportOptions& options, const ImportCache& cache) {
  check_source(file, options);
  const auto origin = can_be_cached(cache, file) ? origin_of(file, options) : std::nullopt;
  return origin && prepare(cache.folder) ? find_either(cache, *origin, file, options) : nullptr;
}

std::shared_ptr<const Dataset> open_import_cached(const fs::path& file, const ImportOptions& asked, const ImportCache& cache, const Task& task) {
  check_source(file, asked);
  ImportOptions options = asked;
  if (!options.needs) options.needs = reader_needs(file);
  const auto origin = can_be_cached(cache, file) ? origin_of(file, options) : std::nullopt;
  if (!origin || !prepare(cache.folder)) return open_import(file, options, task);
  if (auto dataset = find_either(cache, *origin, file, options)) {
    task.report(1, "reading");
    return dataset;
  }
  sweep(cache);
  const Stopwatch stopwatch;
  std::optional<NewFolder> folder;
  try {
    folder.emplace(cache);
    import_into(folder->path(), file, options, task);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::unavailable) throw;
    folder.reset();
    return open_import(file, options, task);  // the disk of the cache is full, say
  }
  std::shared_ptr<const Dataset> dataset = map_import(folder->path(), file, options, ImportFiles::left);
  const bool own = has_own_grid(*dataset, options);
  const double least_ms = 1000 * cache.least_seconds / (own ? 1 : kLessWithoutGrid);
  if (stopwatch.elapsed_ms() >= least_ms && origin_of(file, options) == origin) {  // else it was written to while it was read
    const std::string of_entry = own ? *origin : origin_beside(*origin, *options.like);
    const fs::path place = place_of(cache, of_entry);
    std::ofstream(folder->path() / kMeasures, std::ios::binary) << to_text(measures_of(*dataset));
    std::ofstream(folder->path() / kOriginFile, std::ios::binary) << of_entry;
    const std::uint64_t bytes = bytes_in(folder->path());
    std::error_code error;
    if (bytes <= cache.max_bytes / 2 && fs::space(cache.folder, error).available >= bytes && !error) {
      make_room(cache, bytes);
      folder->become(place);
      if (is_shut_in()) place_facts(*dataset, place);
    }
  }
  task.report(1, "reading");
  return dataset;
}

KeptWork::KeptWork(const fs::path& file, std::string what, const ImportCache& cache) : file_(file), what_(std::move(what)), cache_(cache) {
  origin_ = origin();
}

/// Empty if it cannot be told, or what lies in the cache is not to be believed.
std::string KeptWork::origin() const {
  if (!is_shut_in()) return {};
  check_source(file_, {});
  const auto files = source_files(file_);
  return files ? "work " + what_ + '\n' + fs::absolute(file_).string() + '\n' + *files : std::string();
}

std::optional<std::vector<std::byte>> KeptWork::find() const {
  if (origin_.empty() || !prepare(cache_.folder)) return std::nullopt;
  const fs::path entry = place_of(cache_, origin_);
  if (text_of(entry / kOriginFile) != origin_) return std::nullopt;
  auto work = read_checked(entry / kWork);
  std::error_code ignored;
  if (work)
    fs::last_write_time(entry / kOriginFile, fs::file_time_type::clock::now(), ignored);
  else
    remove_entry(entry);
  return work;
}

void KeptWork::keep(std::span<const std::byte> bytes) const {
  if (origin_.empty() || !prepare(cache_.folder)) return;
  sweep(cache_);
  try {
    if (origin() != origin_) return;
    NewFolder folder(cache_);
    if (!write_checked(folder.path() / kWork, bytes)) return;
    std::ofstream(folder.path() / kOriginFile, std::ios::binary) << origin_;
    make_room(cache_, bytes_in(folder.path()));
    folder.become(place_of(cache_, origin_));
  } catch (const Error&) {  // the file is gone, or there is no room
  }
}

ImportCacheUse use_of(const ImportCache& cache) {
  ImportCacheUse use;
  for (const fs::path& entry : folders(cache, kEntry)) {
    ++use.entries;
    use.bytes += bytes_in(entry);
  }
  return use;
}

void clear(const ImportCache& cache) {
  for (const fs::path& entry : folders(cache, kEntry)) remove_entry(entry);
  sweep(cache);
}

}  // namespace isostrata
