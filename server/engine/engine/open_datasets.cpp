#include "engine/engine/open_datasets.h"

#include <algorithm>

#include "base/error.h"
#include "data/dataset/analytic.h"
#include "data/files/beneath.h"
#include "data/files/look_at_folder.h"
#include "data/values/histogram.h"
#include "data/values/source_mapping.h"

namespace isostrata {
namespace {

void check_unchanged(const CatalogueEntry& of) {
  if (of.mark == 0 || mark_on_disk(of.source, of.parts) == of.mark) return;
  throw Error(ErrorCode::unavailable, of.name + ": has changed on disk since it was opened, or is being written, so that this part of it cannot be read; open it again");
}

std::string without_place(std::string message, const CatalogueEntry& of) {
  const std::string unmarked = without_mark(of.source).string();
  for (const std::string& source : {of.source, unmarked == of.source ? std::string() : unmarked})
    for (auto at = source.empty() ? std::string::npos : message.find(source); at != std::string::npos; at = message.find(source, at + of.name.size()))
      message.replace(at, source.size(), of.name);
  return message;
}

}  // namespace

OpenDatasets::OpenDatasets(Catalogue catalogue, DatasetStoreOptions store, SceneRanks* ranks)
    : options_(std::move(store)),
      ranks_(ranks),
      catalogue_(std::move(catalogue)),
      store_(options_, [this](const std::string& id, int step, const Task& task, std::shared_ptr<const Dataset> like) { return load(id, step, task, std::move(like)); }) {}

CatalogueEntry OpenDatasets::entry(const std::string& id) const {
  const std::lock_guard lock(catalogue_mutex_);
  const CatalogueEntry* found = catalogue_.find(whole_id(id));
  if (!found) throw Error(ErrorCode::not_found, "dataset '" + id + "': not in this server's catalogue");
  CatalogueEntry of = *found;
  of.id = id;
  of.name = part_name(of.name, part_of_id(id));
  return of;
}

std::set<std::string> OpenDatasets::update(std::vector<CatalogueEntry> entries) {
  std::set<std::string> ids;
  const std::lock_guard lock(catalogue_mutex_);
  for (CatalogueEntry& of : entries) {
    ids.insert(of.id);
    const CatalogueEntry* before = catalogue_.find(of.id);
    if (before && before->parts < of.parts) grown_[of.id] = of.parts;
    catalogue_.put(std::move(of));
  }
  return ids;
}

// One version of a dataset is never mixed with another: what was read is of the files that the catalogue lists, or it is not used.
std::shared_ptr<const Dataset> OpenDatasets::load(const std::string& id, int step, const Task& task, std::shared_ptr<const Dataset> like) const {
  const CatalogueEntry of = entry(id);
  const Region part = part_of_id(id);
  if (ranks_ && part != Region{})
    throw Error(ErrorCode::unsupported, of.name + ": ranks open whole datasets; expected no region and no stride, or those of the server");
  auto dataset = ranks_ ? ranks_->open({of.source, of.id}, step, task) : DatasetStore::open(options_, of.source, step, task, part, std::move(like));
  check_unchanged(of);
  return dataset;
}

// A dataset that was read before its series grew knows of fewer times; whoever looks for one begins with the first step.
std::shared_ptr<const Dataset> OpenDatasets::acquire(const CatalogueEntry& of, int step, const Task& task) {
  auto dataset = acquire_held(of, step, task);
  const auto known = step == 0 ? ranges_.find(of.id) : std::nullopt;
  if (!known || known->times.size() <= dataset->times.size()) return dataset;
  store_.drop(of.id, 0);
  return acquire_held(of, step, task);
}

std::shared_ptr<const Dataset> OpenDatasets::acquire_held(const CatalogueEntry& of, int step, const Task& task) {
  try {
    auto dataset = store_.acquire(of.id, step, task);
    ranges_.add(of.id, *dataset);
    return dataset;
  } catch (const Error& error) {
    throw Error(error.code(), without_place(error.what(), of));
  }
}

StepSource OpenDatasets::steps(const CatalogueEntry& of) {
  return [this, &of](int step, const Task& task) { return acquire(of, step, task); };
}

std::shared_ptr<const Dataset> OpenDatasets::all_of(const CatalogueEntry& of, std::shared_ptr<const Dataset> dataset, const Task& task) const {
  return dataset->whole ? DatasetStore::open(options_, of.source, dataset->step, task) : dataset;
}

StepSource OpenDatasets::whole_steps(const CatalogueEntry& of) {
  return [this, &of](int step, const Task& task) { return all_of(of, acquire(of, step, task), task); };
}

std::shared_ptr<const Dataset> OpenDatasets::glance(const CatalogueEntry& of, int step, const Region& part, const Glance& limits, const Task& task) const {
  if (auto held = store_.held(of.id, step); held && !held->whole) return held;
  DatasetStoreOptions options = options_;
  options.max_bytes = std::min(options.max_bytes, limits.max_bytes);
  options.timeout_s = std::min(options.timeout_s, limits.timeout_s);
  options.keep.clear();
  options.cache = false;
  check_unchanged(of);
  try {
    auto dataset = DatasetStore::open(options, of.source, step, task, part);
    check_unchanged(of);
    return dataset;
  } catch (const Error& error) {
    throw Error(error.code(), without_place(error.what(), of));
  }
}

std::optional<KeptWork> OpenDatasets::kept_work(const CatalogueEntry& of, const std::string& what) {
  if (!import_cache() || is_analytic(of.source)) return std::nullopt;
  check_unchanged(of);
  try {
    return KeptWork(of.source, what, *import_cache());
  } catch (const Error& error) {
    throw Error(error.code(), without_place(error.what(), of));
  }
}

DatasetFacts OpenDatasets::describe(const std::string& id, const Task& task) {
  const CatalogueEntry of = entry(id);
  const auto dataset = acquire_held(of, 0, task);
  look_for_steps(of, *dataset, task);
  FirstView view = view_of_series(of, dataset, task);  // may read steps: what is known of the ranges is asked for afterwards
  if (ranks_)
    for (const PointArray& array : dataset->arrays) drop_pages(array);  // samples of all of it, which this rank does not keep
  const KnownRanges::Known known = ranges_.find(of.id).value_or(KnownRanges::Known{SeriesRanges(*dataset), {}, {}, {}});
  DatasetFacts facts = dataset_facts(of.id, of.name, *dataset, known.ranges);
  if (known.times.size() > facts.times.size()) {
    facts.times = known.times;
    facts.notes = known.said;
  }
  facts.notes.insert(facts.notes.end(), known.notes.begin(), known.notes.end());
  if (const auto boxes = known.ranges.note_of_boxes()) facts.notes.push_back(*boxes);
  facts.first_view = std::move(view);
  return facts;
}

// Of a series that has grown the first new step says what times there are; it is what somebody will look at next, too.
void OpenDatasets::look_for_steps(const CatalogueEntry& of, const Dataset& first_step, const Task& task) {
  int parts = 0;
  {
    const std::lock_guard lock(catalogue_mutex_);
    const auto grown = grown_.find(whole_id(of.id));  // a box of it has the new steps, too
    if (grown == grown_.end() || looked_[of.id] == grown->second) return;
    parts = grown->second;
  }
  const auto known = ranges_.find(of.id);
  const auto steps = static_cast<int>(known ? known->times.size() : first_step.times.size());
  try {
    acquire_held(of, steps, task);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::not_found) throw;  // else what has come is not a step
  }
  const std::lock_guard lock(catalogue_mutex_);
  looked_[of.id] = parts;
}

// Made once for a dataset that is held. A series of which nothing was to be seen is looked at again, for steps may be known by then that
// have more.
FirstView OpenDatasets::view_of_series(const CatalogueEntry& of, const std::shared_ptr<const Dataset>& first_step, const Task& task) {
  {
    const std::lock_guard lock(views_mutex_);
    if (const auto it = views_.find(of.id); it != views_.end() && it->second.first.lock() == first_step) return it->second.second;
  }
  const auto all = all_of(of, first_step, task);
  const auto borrow = [&](int step, const Task& reading) {
    if (first_step->whole && step == all->step) return all;
    auto dataset = store_.borrow(of.id, step, reading);
    ranges_.add(of.id, *dataset);
    return dataset;
  };
  FirstView view = first_view(*all, borrow, {}, task);
  if (view.array.empty()) {
    const auto known = ranges_.find(of.id);
    for (const ArrayRanges& array : known ? known->ranges.arrays() : std::vector<ArrayRanges>{})
      if (array.all.lower < array.all.upper) return first_view(*all, borrow, {array.name, known->ranges.widest_step(array.name)}, task);
    return view;
  }
  const std::lock_guard lock(views_mutex_);
  std::erase_if(views_, [](const auto& held) { return held.second.first.expired(); });
  views_[of.id] = {first_step, view};
  return view;
}

std::optional<OpenDatasets::NextStep> OpenDatasets::next_unknown(const std::string& id, const Task& task) {
  if (!ranges_.next(id)) acquire(entry(id), 0, task);
  const int step = *ranges_.next(id);
  if (step < 0) return std::nullopt;
  const SeriesRanges known = ranges_.find(id)->ranges;
  return NextStep{step, static_cast<double>(known.known_steps()), static_cast<double>(known.steps())};
}

void OpenDatasets::read_ranges(const std::string& id, int step, const Task& task) {
  const CatalogueEntry of = entry(id);
  try {
    ranges_.add(of.id, *store_.borrow(of.id, step, task));
  } catch (const Error& error) {
    if (error.code() == ErrorCode::cancelled) throw;
    ranges_.skip(of.id, step, without_place(error.what(), of));
  }
}

// Whether each rank looks at its part of the values: this process has a part, too, or has them mapped and keeps none of them in memory.
bool OpenDatasets::by_ranks(const Dataset& dataset, const PointArray& array) const {
  return ranks_ && (dataset.whole || std::visit([](auto values) { return !values.empty() && is_in_source(values.data()); }, array.values));
}

std::vector<std::uint64_t> OpenDatasets::histogram(const std::string& id, const std::shared_ptr<const Dataset>& dataset, const PointArray& array,
                                                   ValueRange range, int bins, const Task& task) const {
  if (!by_ranks(*dataset, array)) return kept_histogram(array, range.lower, range.upper, bins);
  const CatalogueEntry of = entry(id);
  return ranks_->histogram({of.source, of.id}, dataset, array.name, range.lower, range.upper, bins, task);
}

Statistics OpenDatasets::statistics(const std::string& id, const std::shared_ptr<const Dataset>& dataset, const PointArray& array, const Task& task) const {
  if (!by_ranks(*dataset, array)) return isostrata::statistics(array);
  const CatalogueEntry of = entry(id);
  return ranks_->statistics({of.source, of.id}, dataset, array.name, task);
}

}  // namespace isostrata
