#include "engine/data/dataset_store.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <new>

#include "base/work.h"
#include "data/dataset/analytic.h"
#include "data/dataset/dataset_bytes.h"
#include "data/grids/same_grid.h"
#include "data/open/import_cache.h"
#include "data/open/import_door.h"

namespace isostrata {

struct DatasetStore::Loading {
  explicit Loading(Task::Listener listener) : task(std::move(listener)) {}
  Task task;
  int waiting = 0;
  bool done = false;
  double fraction = 0;
  std::string stage = "reading";
  std::shared_ptr<const Dataset> dataset;
  std::exception_ptr failure;
};

DatasetStore::DatasetStore(DatasetStoreOptions options)
    : DatasetStore(options, [options](const std::string& source, int step, const Task& task, std::shared_ptr<const Dataset> like) {
        return open(options, source, step, task, {}, std::move(like));
      }) {}

std::shared_ptr<const Dataset> DatasetStore::open(const DatasetStoreOptions& options, const std::string& source, int step, const Task& task,
                                                  const Region& part, std::shared_ptr<const Dataset> like) {
  ImportOptions open({}, std::move(like));
  open.step = step;
  open.importer = options.importer;
  open.max_bytes = options.max_bytes;
  open.timeout_s = options.timeout_s;
  if (part != Region{}) return open_part(source, open, part, task);
  if (options.part != Region{}) try {
      return open_part(source, open, options.part, task);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::unsupported) throw;  // an unstructured grid has no parts
    }
  if (is_analytic(source)) return open_dataset(source, open, task);
  if (!options.cache) {
    auto kept = import_cache() ? find_import_cached(source, open, *import_cache()) : nullptr;
    return kept ? kept : open_import(source, open, task);
  }
  if (import_cache() && (options.keep.empty() || can_be_cached(*import_cache(), source))) return open_import_cached(source, open, *import_cache(), task);
  return options.keep.empty() ? open_import(source, open, task) : open_import_keeping(source, open, options.keep, task);
}

namespace {

/// The dataset on the other's grid, if they are the same: one mesh for all steps, by whose place in memory others know it. The dataset as it was
/// read stays with it, for its files may have to.
std::shared_ptr<const Dataset> on_grid_of(const std::shared_ptr<const Dataset>& other, std::shared_ptr<const Dataset> dataset) {
  if (!other || !dataset->grid.storage || dataset->grid.storage == other->grid.storage || !same_grid(other->grid, dataset->grid)) return dataset;
  struct Shared {
    Dataset dataset;
    std::shared_ptr<const Dataset> as_read;
  };
  auto shared = std::make_shared<Shared>(Shared{*dataset, dataset});
  shared->dataset.grid = other->grid;
  return {shared, &shared->dataset};
}

/// What it takes beside the grid of `other`.
std::uint64_t bytes_beside(const Dataset* other, const Dataset& dataset) {
  if (!other || other->grid.storage != dataset.grid.storage) return dataset_bytes(dataset);
  Dataset arrays;
  arrays.arrays = dataset.arrays;
  return dataset_bytes(arrays);
}

}  // namespace

DatasetStore::DatasetStore(DatasetStoreOptions options, Loader loader)
    : options_(std::move(options)), loader_(std::move(loader)) {}

DatasetStore::~DatasetStore() {
  std::unique_lock lock(mutex_);
  for (auto& [key, loading] : loading_) loading->task.cancel();
  changed_.wait(lock, [&] { return threads_ == 0; });
}

std::shared_ptr<const Dataset> DatasetStore::acquire(const std::string& source, int step, const Task& task) {
  task.check();
  const Key key{source, step};
  std::unique_lock lock(mutex_);
  if (const auto it = held_.find(key); it != held_.end()) {
    it->second.last_use = ++uses_;
    return it->second.dataset;
  }
  std::shared_ptr<Loading>& slot = loading_[key];
  if (!slot || slot->task.cancelled()) {
    // The listener may outlive this call, so it holds the store only, which waits for its threads.
    auto weak = std::make_shared<std::weak_ptr<Loading>>();
    slot = std::make_shared<Loading>([this, weak](double fraction, std::string_view stage) {
      const auto loading = weak->lock();
      if (!loading) return;
      std::lock_guard inner(mutex_);
      loading->fraction = fraction;
      loading->stage = stage;
    });
    *weak = slot;
    ++threads_;
    try {
      const Work* const asker = current_work();
      std::thread([this, loading = slot, key, session = asker ? std::optional(asker->session()) : std::nullopt] {
        load(loading, key, session);
      }).detach();
    } catch (...) {
      --threads_;
      loading_.erase(key);
      throw Error(ErrorCode::unavailable, "no thread could be started to load the dataset");
    }
  }
  const std::shared_ptr<Loading> loading = slot;
  ++loading->waiting;
  while (!loading->done) {
    changed_.wait_for(lock, std::chrono::milliseconds(20));
    const double fraction = loading->fraction;
    const std::string stage = loading->stage;
    if (task.cancelled() && !loading->done) {
      if (--loading->waiting == 0) loading->task.cancel();
      lock.unlock();
      task.check();
    }
    lock.unlock();
    task.report(fraction, stage);
    lock.lock();
  }
  --loading->waiting;
  if (loading->failure) std::rethrow_exception(loading->failure);
  // The last one takes it away: the thread that loaded it may live a little longer, and what it held would count as in use.
  return loading->waiting == 0 ? std::move(loading->dataset) : loading->dataset;
}

std::shared_ptr<const Dataset> DatasetStore::borrow(const std::string& source, int step, const Task& task) {
  auto dataset = held(source, step);
  return dataset ? dataset : loader_(source, step, task, nullptr);
}

std::shared_ptr<const Dataset> DatasetStore::held(const std::string& source, int step) const {
  const std::lock_guard lock(mutex_);
  const auto it = held_.find({source, step});
  return it == held_.end() ? nullptr : it->second.dataset;
}

void DatasetStore::load(std::shared_ptr<Loading> loading, Key key, std::optional<std::uint64_t> session) {
  std::shared_ptr<const Dataset> dataset, like;
  std::exception_ptr failure;
  {
    const std::lock_guard lock(mutex_);
    // One step stands for the others: a mesh that moves is another at each. The first, which is the same one at the next run: what is kept on its mesh is found.
    const auto first = held_.lower_bound({key.first, 0});
    if (first != held_.end() && first->first.first == key.first) like = first->second.dataset;
  }
  try {
    std::optional<Work> work;
    if (session) work.emplace(*session, WorkClass::scene, Work::Options{&loading->task});
    dataset = on_grid_of(like, loader_(key.first, key.second, loading->task, like));
  } catch (const std::bad_alloc&) {
    failure = std::make_exception_ptr(Error(ErrorCode::too_large, "the dataset does not fit in memory"));
  } catch (...) {
    failure = std::current_exception();
  }
  std::lock_guard lock(mutex_);
  if (loading->waiting > 0) loading->dataset = dataset;
  loading->failure = failure;
  loading->done = true;
  if (const auto it = loading_.find(key); it != loading_.end() && it->second == loading) loading_.erase(it);
  if (dataset) {
    const std::uint64_t bytes = bytes_beside(like.get(), *dataset);
    like.reset();  // it may go
    held_[key] = {std::move(dataset), bytes, ++uses_};
    drop_unused();
  }
  --threads_;
  changed_.notify_all();
}

void DatasetStore::drop_unused() {
  for (;;) {
    std::uint64_t bytes = 0;
    auto oldest = held_.end();
    for (auto it = held_.begin(); it != held_.end(); ++it) {
      bytes += it->second.bytes;
      // The newest one has not been handed to those who wait for it yet, so it stays.
      if (it->second.dataset.use_count() == 1 && it->second.last_use != uses_ &&
          (oldest == held_.end() || it->second.last_use < oldest->second.last_use))
        oldest = it;
    }
    if (bytes <= options_.max_bytes || oldest == held_.end()) return;
    held_.erase(oldest);
  }
}

void DatasetStore::drop(const std::string& source, int step) {
  const std::lock_guard lock(mutex_);
  held_.erase({source, step});
}

bool DatasetStore::has_room_for(const std::string& source, int step) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0, largest = 0;
  for (const auto& [key, held] : held_) {
    bytes += held.bytes;
    if (key.first == source) largest = std::max(largest, held.bytes);
    if (key == Key{source, step}) return false;
  }
  return !loading_.contains({source, step}) && bytes + largest <= options_.max_bytes / 2;
}

std::uint64_t DatasetStore::held_bytes() const {
  std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const auto& [key, held] : held_) bytes += held.bytes;
  return bytes;
}

}  // namespace isostrata
