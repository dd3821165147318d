#include "engine/data/living_catalogue.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

#include "base/error.h"
#include "base/unix_time.h"
#include "data/dataset/analytic.h"
#include "data/files/beneath.h"
#include "data/files/file_series.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostLatest = 20;
constexpr milliseconds kLookAgain{1000};  // at what is being written, and for a folder that is gone

/// One of the sources that a server was started with.
struct Source {
  std::string text;
  std::optional<FolderLister> folder;  // of a directory
  fs::path root;                       // its real path; of a file or a pattern that of the directory it lies in
  bool stale = true;
  bool there = true;
};

/// What is known of an entry beside what clients see.
struct Known {
  CatalogueEntry entry;
  std::vector<std::uint64_t> marks;  // FolderEntry::marks of the complete parts
  std::uint64_t mark = 0;            // FolderEntry::mark when all of it was complete; 0: it never was
  std::size_t source = 0;            // of the sources, which one it is of
  bool seen = false;                 // in the newest listing
  bool gone() const { return entry.news == CatalogueNews::gone; }
};

}  // namespace

class LivingCatalogue::Impl {
 public:
  Impl(const std::vector<std::string>& sources, LivingOptions options) : options_(options), watch_(options.watch) {
    for (const std::string& text : sources) {
      Source& source = sources_.emplace_back();
      source.text = text;
      std::error_code error;
      if (is_analytic(text)) continue;
      if (fs::is_directory(text, error)) {
        source.root = fs::canonical(text);
        source.folder.emplace(source.root);
      } else if (fs::is_regular_file(text, error) || is_series_pattern(text)) {
        source.root = is_series_pattern(text) ? fs::canonical(fs::absolute(text).parent_path()) : fs::canonical(text).parent_path();
      } else {
        static_cast<void>(Catalogue::from_sources({text}));  // throws
      }
    }
    list();
    first_ = false;
  }

  ~Impl() { stop(); }

  void stop() {
    stopping_ = true;
    watch_.stop();
    if (thread_.joinable()) thread_.join();
  }

  void follow(Told told) {
    told_ = std::move(told);
    thread_ = std::thread([this] {
      setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), 5);
      run();
    });
  }

  std::shared_ptr<const Catalogue> now() const {
    const std::lock_guard lock(mutex_);
    return now_;
  }
  std::string how() const {
    const std::lock_guard lock(mutex_);
    return how_;
  }

 private:
  void run() {
    while (!stopping_) {
      const FolderWatch::News news = watch_.wait(kLookAgain);
      if (stopping_) return;
      const bool look = news.everything || again_;
      std::set<fs::path> folders = std::move(look_again_);
      look_again_.clear();
      folders.insert(news.folders.begin(), news.folders.end());
      bool any = look;
      for (Source& source : sources_) {
        if (news.everything && source.folder) source.folder->look_again_everywhere();
        source.stale = news.everything || !source.there;
        for (const fs::path& folder : folders) {
          const bool below = folder == source.root || (source.folder && folder.native().starts_with(source.root.native() + "/"));
          if (!below) continue;
          if (source.folder) source.folder->look_again(folder);
          source.stale = any = true;
        }
      }
      try {
        if (any) list();
      } catch (const std::exception&) {  // no memory, or something went away while it was looked at
        for (Source& source : sources_)
          if (source.folder) source.folder->look_again_everywhere();
        again_ = true;
      }
    }
  }

  /// Reads what is stale, and hands out a new catalogue where anything is different.
  void list() {
    again_ = false;
    changed_ = first_;
    if (first_) watch_all();  // before files that are named are looked at
    for (Source& source : sources_) {
      place_ = static_cast<std::size_t>(&source - sources_.data());
      if (source.folder && source.stale)
        list_folder(source);
      else if (is_analytic(source.text) && first_)
        take_all(source.text, [&] { take({{}, source.text, source.text}, {}, 1, 1); });
      else if (!source.folder && !source.root.empty())
        take_all(source.text, [&] { take_file(source); });
    }
    forget_gone();
    again_ = again_ || !look_again_.empty();
    hand_out();
  }

  void list_folder(Source& source) {
    for (int round = 0; round < 3; ++round) {  // a folder that is watched from now on is looked at once more
      std::set<fs::path> renewed;
      try {
        renewed = source.folder->renew(watch_.writing());
        source.there = true;
      } catch (const Error&) {
        if (first_) throw;
        for (const auto& [folder, keys] : in_folder_)
          if (fs::path(folder) == source.root || folder.starts_with(source.root.native() + "/")) renewed.insert(folder);
        source.there = false;
        source.folder->look_again_everywhere();
        again_ = true;
      }
      for (const fs::path& folder : renewed) {
        const auto part = source.folder->parts().find(folder);
        take_all(folder.native(), [&] {
          if (part == source.folder->parts().end()) return;
          for (const FolderEntry& listed : part->second.entries) {
            if (listed.writing) look_again_.insert(folder);
            take(Catalogue::entry_of(source.root, listed), listed.marks, listed.mark, listed.settled);
          }
        });
      }
      bool more = false;
      for (const fs::path& folder : watch_all())
        if (source.folder->parts().contains(folder)) {
          source.folder->look_again(folder);
          more = true;
        }
      if (!more) break;
    }
    source.stale = false;
  }

  /// Gives the folders that are watched from now on.
  std::set<fs::path> watch_all() {
    std::set<fs::path> folders, lone;
    for (const Source& of : sources_) {
      if (of.folder)
        for (const auto& [folder, part] : of.folder->parts()) folders.insert(folder);
      else if (!of.root.empty())
        lone.insert(of.root);
    }
    return watch_.watch(folders, lone);
  }

  /// What `take_them` takes is all that there is in this place now; what was there and is not is gone.
  template <class TakeThem>
  void take_all(const std::string& folder, const TakeThem& take_them) {
    place_in_ = folder;
    for (const std::string& key : in_folder_[folder]) known_.at(key).seen = false;
    take_them();
    std::vector<std::string>& keys = in_folder_[folder];
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    std::erase_if(keys, [&](const std::string& key) { return !known_.contains(key); });  // taken over
    for (const std::string& key : keys) {
      Known& known = known_.at(key);
      if (known.seen || known.gone()) continue;
      known.entry.writing = false;
      note(known.entry, CatalogueNews::gone);
    }
    if (keys.empty()) in_folder_.erase(folder);
  }

  /// The newest catalogue, the entries in the order of the sources, those of a directory in the order of their names.
  void hand_out() {
    const std::vector<PassedOver> passed_over = all_passed_over();
    std::int64_t passed = 0;
    for (const PassedOver& of : passed_over) passed += of.files;
    std::shared_ptr<Catalogue> catalogue;
    if (changed_ || passed != passed_) {
      const auto before = [](const Known* a, const Known* b) {
        return std::tie(a->source, a->entry.name, a->entry.source) < std::tie(b->source, b->entry.name, b->entry.source);
      };
      if (resort_) std::sort(order_.begin(), order_.end(), before);
      resort_ = false;
      for (Known* known : order_)
        if (known->entry.id.empty()) known->entry.id = Catalogue::new_id(known->entry, ids_);
      catalogue = std::make_shared<Catalogue>();
      catalogue->reserve(order_.size());
      for (const Known* known : order_) catalogue->put(known->entry);
      catalogue->pass_over(passed_over);
      for (const Source& source : sources_)
        if (source.folder && source.folder->cut_off()) catalogue->set_cut_off();
      std::vector<CatalogueEntry> latest;
      for (const std::string& key : noted_)
        if (const auto at = known_.find(key); at != known_.end() && latest.size() < kMostLatest) latest.push_back(at->second.entry);
      catalogue->set_latest(std::move(latest));
    }
    noted_.clear();
    passed_ = passed;
    std::shared_ptr<const Catalogue> old;  // is destroyed here, not where somebody waits
    {
      const std::lock_guard lock(mutex_);
      how_ = watch_.how();
      if (!catalogue) return;
      old = std::exchange(before_, std::exchange(now_, catalogue));
    }
    if (told_) told_(catalogue);
  }

  std::vector<PassedOver> all_passed_over() const {
    PassedOverSum all;
    for (const Source& source : sources_)
      if (source.folder)
        for (const auto& [folder, part] : source.folder->parts()) all.add(part.passed_over);
    return all.most_first();
  }

  void take_file(Source& source) {
    CatalogueEntry entry;
    try {
      entry = Catalogue::entry_of(source.text);
    } catch (const std::exception&) {
      if (first_) throw;
      again_ = true;  // it may come back
      return;
    }
    const std::set<std::string> writing = watch_.writing();
    std::vector<std::uint64_t> marks;
    int settled = 0;
    const fs::path plain = without_mark(entry.source);
    if (is_series_pattern(plain)) {
      std::uint64_t mark = 0;
      for (const SeriesFile& file : series_files(plain)) {
        mark = mark_of(mark, file.path.filename().string(), file_stamp(file.path).value_or(FileStamp{}));
        marks.push_back(mark);
        entry.writing = entry.writing || writing.contains(file.path.string());
        if (!entry.writing) ++settled;
      }
      if (!marks.empty()) entry.mark = marks.back();
    } else {
      entry.writing = writing.contains(plain.string());
      settled = !entry.writing;
    }
    again_ = again_ || entry.writing;
    const std::uint64_t mark = entry.mark;
    take(std::move(entry), std::move(marks), mark, settled);
  }

  /// What is listed now, against what is known of it.
  void take(CatalogueEntry entry, std::vector<std::uint64_t> marks, std::uint64_t mark, int settled) {
    const std::string key = without_mark(entry.source).string();
    key_ = key;
    auto at = known_.find(key);
    if (at == known_.end()) at = take_over(key, marks);
    if (at == known_.end()) {
      if (known_.size() >= Catalogue::kMaxEntries) return;
      Known& known = known_[key];
      in_folder_[place_in_].push_back(key);
      order_.push_back(&known);
      resort_ = changed_ = true;
      if (!first_) note(entry, CatalogueNews::appeared);
      use_settled(entry, marks, settled);
      check_mark(entry);
      known.mark = entry.writing ? 0 : mark;
      known.entry = std::move(entry);
      known.marks = std::move(marks);
      known.source = place_;
      known.seen = true;
      index_mark(key, known);
      return;
    }
    Known& known = at->second;
    known.seen = true;
    const CatalogueEntry& before = known.entry;
    entry.id = before.id;
    entry.version = before.version;
    entry.news = before.news;
    entry.noticed_unix_ms = before.noticed_unix_ms;
    if (entry.name != before.name) resort_ = changed_ = true;
    if (entry.writing != before.writing) changed_ = true;
    const auto had = static_cast<std::size_t>(std::max(before.parts, 0));
    const auto complete = static_cast<std::size_t>(entry.writing ? settled : static_cast<int>(marks.size()));
    const bool same_beginning = had >= 1 && complete >= had && marks.size() >= had && marks[had - 1] == first_marks_of(known, had);
    if (before.news == CatalogueNews::gone) {
      if (mark != known.mark) ++entry.version;
      note(entry, mark != known.mark ? CatalogueNews::changed : CatalogueNews::appeared);
    } else if (mark == known.mark) {
      entry.mark = before.mark;  // as it was
      if (entry.writing) keep_version(entry, before);
    } else if (same_beginning && complete > had) {
      note(entry, CatalogueNews::grown);
    } else if (entry.writing) {
      keep_version(entry, before);
      changed_ = changed_ || entry.bytes != before.bytes;
      known.entry = std::move(entry);
      return;
    } else if (same_beginning && !known.marks.empty() && known.mark == 0) {
      // A file at the end that was being written is not there any more.
      note(entry, CatalogueNews::changed);
    } else {
      ++entry.version;
      note(entry, known.mark == 0 && before.news == CatalogueNews::appeared ? CatalogueNews::appeared : CatalogueNews::changed);
    }
    use_settled(entry, marks, settled);
    if (mark != known.mark) check_mark(entry);
    if (mark != known.mark) known.mark = entry.writing ? 0 : mark;
    known.entry = std::move(entry);
    known.marks = std::move(marks);
    index_mark(key, known);
  }

  void index_mark(const std::string& key, const Known& known) {
    if (known.marks.empty() && known.mark != 0) by_mark_[known.mark] = key;
  }

  /// A pattern may find more files than are listed under it (one of another kind, a piece of another file): then nothing can be compared.
  static void check_mark(CatalogueEntry& entry) {
    if (entry.mark != 0 && is_series_pattern(without_mark(entry.source)) && mark_on_disk(entry.source, entry.parts) != entry.mark) entry.mark = 0;
  }

  static std::uint64_t first_marks_of(const Known& known, std::size_t parts) {
    if (known.marks.empty()) return known.mark;  // one file, the first of a series now
    return parts <= known.marks.size() ? known.marks[parts - 1] : 0;
  }

  /// Until what is being written is complete, the version is that before.
  static void keep_version(CatalogueEntry& entry, const CatalogueEntry& before) {
    entry.parts = before.parts;
    entry.mark = before.mark;
  }

  static void use_settled(CatalogueEntry& entry, std::vector<std::uint64_t>& marks, int settled) {
    if (!entry.writing) return;
    entry.parts = settled;
    if (marks.empty()) return;
    const bool checked = entry.mark != 0;
    marks.resize(static_cast<std::size_t>(std::max(settled, 0)));
    entry.mark = checked && !marks.empty() ? marks.back() : 0;
  }

  /// A file becomes a series when a second one follows: the entry is the same, under another name.
  std::unordered_map<std::string, Known>::iterator take_over(const std::string& key, const std::vector<std::uint64_t>& marks) {
    if (marks.size() < 2 || !is_series_pattern(key)) return known_.end();
    const auto first = by_mark_.find(marks.front());
    if (first == by_mark_.end()) return known_.end();
    const auto old = known_.find(first->second);
    if (old == known_.end() || old->second.seen || fs::path(old->first).parent_path() != fs::path(key).parent_path()) return known_.end();
    in_folder_[place_in_].push_back(key);
    auto node = known_.extract(old);  // where it lies in memory does not change
    node.key() = key;
    return known_.insert(std::move(node)).position;
  }

  void note(CatalogueEntry& entry, CatalogueNews news) {
    entry.news = news;
    entry.noticed_unix_ms = unix_ms_now();
    changed_ = true;
    if (noted_.size() < kMostLatest) noted_.push_back(entry.source.empty() ? key_ : without_mark(entry.source).string());
  }

  /// An entry is listed as gone for a while.
  void forget_gone() {
    const UnixMs now = unix_ms_now();
    std::vector<const Known*> gone;
    for (const Known* known : order_)
      if (known->gone()) gone.push_back(known);
    if (gone.empty()) return;
    std::sort(gone.begin(), gone.end(), [](const Known* a, const Known* b) { return a->entry.noticed_unix_ms > b->entry.noticed_unix_ms; });
    std::set<const Known*> over;
    for (std::size_t i = 0; i < gone.size(); ++i)
      if (i >= options_.most_gone || now - gone[i]->entry.noticed_unix_ms > options_.keep_gone.count()) over.insert(gone[i]);
    if (over.empty()) return;
    changed_ = true;
    std::erase_if(order_, [&](const Known* known) { return over.contains(known); });
    std::erase_if(known_, [&](const auto& of) { return over.contains(&of.second); });
    for (auto& [folder, keys] : in_folder_) std::erase_if(keys, [&](const std::string& key) { return !known_.contains(key); });
  }

  const LivingOptions options_;
  FolderWatch watch_;
  std::vector<Source> sources_;
  std::unordered_map<std::string, Known> known_;                               // by source, without its mark
  std::unordered_map<std::string, std::vector<std::string>> in_folder_;        // sources by the folder that lists them, or the text of a source that is a file
  std::vector<Known*> order_;                                                  // all, sorted where resort_ does not say otherwise
  std::unordered_set<std::string> ids_;                                        // that were given
  std::vector<std::string> noted_;                                             // sources with news since the last catalogue
  std::string place_in_, key_;                                                 // of in_folder_ and known_, what is being taken
  std::int64_t passed_ = -1;                                                   // files that were passed over
  bool resort_ = false;
  std::unordered_map<std::uint64_t, std::string> by_mark_;        // sources of single files
  std::set<fs::path> look_again_;                                 // folders in which something is being written
  bool again_ = false, changed_ = false, first_ = true;
  std::size_t place_ = 0;  // of the source that is being taken
  Told told_;
  std::thread thread_;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;  // guards what follows
  std::shared_ptr<const Catalogue> now_, before_;
  std::string how_;
};

LivingCatalogue::LivingCatalogue(std::vector<std::string> sources, LivingOptions options) : impl_(std::make_unique<Impl>(sources, options)) {}
LivingCatalogue::~LivingCatalogue() = default;
void LivingCatalogue::follow(Told told) { impl_->follow(std::move(told)); }
void LivingCatalogue::stop() { impl_->stop(); }
std::shared_ptr<const Catalogue> LivingCatalogue::now() const { return impl_->now(); }
std::string LivingCatalogue::how() const { return impl_->how(); }

}  // namespace isostrata
