#include "data/files/list_folder.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>

#include "base/error.h"
#include "base/utf8.h"
#include "data/files/file_series.h"
#include "data/files/several_resolutions.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
constexpr int kMaxDepth = 8;
constexpr std::int64_t kMostListed = 200'000;
constexpr std::int64_t kQuietNs = 2'000'000'000;  // since a folder of an OpenFOAM case, of a Zarr image or of a plotfile got its last file
constexpr std::size_t kLeastSlices = 3;  // two pictures with numbers are two pictures

constexpr const char* kPiece = "belongs to another file: a piece, a part or a step that is listed there";

/// Kinds whose numbered files are steps.
bool is_step(FileKind kind) {
  switch (kind) {
    case FileKind::pvd: case FileKind::series: case FileKind::openfoam: case FileKind::ensight: case FileKind::plot3d: case FileKind::dicom:
      return false;
    default:
      return true;
  }
}

using Folders = std::map<fs::path, FolderContents>;

/// Makes one folder's part of the listing of what was looked at.
class Listing {
 public:
  Listing(const fs::path& root, const Folders& folders, const std::set<std::string>& pieces, const std::set<std::string>& writing)
      : root_(root), folders_(folders), pieces_(pieces), writing_(writing) {}

  FolderLister::Part run(const fs::path& folder) {
    list(folder, folders_.at(folder));
    for (auto& [reason, passed] : passed_) out_.passed_over.push_back(std::move(passed));
    return std::move(out_);
  }

 private:
  /// Below the root, as text: lexically_relative takes long if there are many.
  std::string below(const fs::path& path) const {
    if (path == root_) return root_.filename().string();
    const std::string &text = path.native(), &root = root_.native();
    return text.substr(root.size() + (root.ends_with('/') ? 0 : 1));
  }

  void pass_over(const fs::path& folder, const std::string& name, const std::string& reason) {
    PassedOver& passed = passed_[reason];
    passed.reason = reason;
    ++passed.files;
    if (passed.examples.size() < 3) passed.examples.push_back(valid_utf8(below(folder / name)));
  }

  bool is_piece(const fs::path& folder, const std::string& name) const { return !pieces_.empty() && pieces_.contains((folder / name).string()); }

  const LookedAt* find(const fs::path& file) const {
    const auto at = folders_.find(file.parent_path());
    return at == folders_.end() ? nullptr : at->second.find(file.filename().string());
  }

  FolderEntry* add(const fs::path& source, FileKind kind, const fs::path& folder, const std::vector<const LookedAt*>& files) {
    FolderEntry& entry = out_.entries.emplace_back();
    entry.name = below(source);
    entry.source = source.string();
    entry.kind = kind;
    entry.files = static_cast<int>(files.size());
    entry.settled = 0;
    std::vector<std::string> names;
    for (const LookedAt* file : files) {
      names.push_back(file->name);
      note(entry, folder, *file);
      if (files.size() > 1) entry.marks.push_back(entry.mark);
      if (!entry.writing) ++entry.settled;
    }
    entry.numbers = equal_steps(source.filename().string(), names);
    return &entry;
  }

  void note(FolderEntry& entry, const fs::path& folder, const LookedAt& file) const {
    entry.bytes += file.stamp.bytes;
    entry.changed = std::max(entry.changed, file.stamp.changed_ns / 1'000'000);
    entry.mark = mark_of(entry.mark, file.name, file.stamp);
    entry.writing = entry.writing || (!writing_.empty() && writing_.contains((folder / file.name).string()));
  }

  /// What a file lists is part of it: its size, its time, and whether it has grown.
  void add_listed(FolderEntry& entry, const fs::path& folder, const LookedAt& list) const {
    if (list.refers_to.empty()) return;
    std::uint64_t mark = 0;
    entry.settled = 0;
    for (const std::string& name : list.refers_to) {
      if (name.find('*') != std::string::npos) continue;
      const fs::path path = (folder / name).lexically_normal();
      const LookedAt* file = find(path);
      mark = mark_of(mark, name, file ? file->stamp : FileStamp{});
      entry.marks.push_back(mark);
      if (file) note(entry, path.parent_path(), *file);
      if (!entry.writing) ++entry.settled;
    }
  }

  void list(const fs::path& folder, const FolderContents& contents) {
    if (contents.dataset == FileKind::openfoam) return list_case(folder, contents);
    if (contents.dataset == FileKind::amrex && folder != root_) return;  // the folder around it lists it, as a step if it is one of several
    if (contents.dataset) return list_levels(folder, contents);
    for (const auto& [name, why] : contents.passed_over) pass_over(folder, name, why);
    std::vector<const LookedAt*> dicom, pictures;
    std::map<FileKind, std::vector<const LookedAt*>> steps;
    for (const LookedAt& file : contents.files) {
      if (file.use == LookedAt::Use::dicom)
        dicom.push_back(&file);
      else if (is_piece(folder, file.name))
        pass_over(folder, file.name, kPiece);
      else if (file.use == LookedAt::Use::picture)
        pictures.push_back(&file);
      else if (file.use == LookedAt::Use::none)
        pass_over(folder, file.name, file.why_not);
      else if (is_step(file.of.kind))
        steps[file.of.kind].push_back(&file);
      else if (FolderEntry* entry = add(folder / file.name, file.of.kind, folder, {&file}))
        add_listed(*entry, folder, file);
    }
    if (!dicom.empty()) add(dicom.size() == 1 ? folder / dicom.front()->name : folder, FileKind::dicom, folder, dicom);
    for (const auto& [kind, files] : steps)
      for (const auto& [name, members] : grouped(files)) {
        if (!is_being_written(folder, members) && are_several_resolutions(folder, members))
          for (const LookedAt* file : members) add_step(folder / file->name, kind, folder, {file});
        else
          add_step(folder / name, kind, folder, members);
      }
    list_pictures(folder, pictures);
    list_plotfiles(folder, contents.folders);
  }

  /// Numbered ones are steps, as files are.
  void list_plotfiles(const fs::path& folder, const std::vector<std::string>& inner) {
    std::vector<std::string> plotfiles;
    for (const std::string& name : inner)
      if (const auto at = folders_.find(folder / name); at != folders_.end() && at->second.dataset == FileKind::amrex) plotfiles.push_back(name);
    for (const NameGroup& group : group_by_number(std::move(plotfiles))) {
      if (group.members.size() == 1) {
        list_levels(folder / group.name, folders_.at(folder / group.name));
        continue;
      }
      FolderEntry& entry = out_.entries.emplace_back();
      entry.name = below(folder / group.name);
      entry.source = (folder / group.name).string();
      entry.kind = FileKind::amrex;
      entry.files = static_cast<int>(group.members.size());
      entry.numbers = equal_steps(group.name, group.members);
      entry.settled = 0;
      for (const std::string& member : group.members) {
        const FolderContents& contents = folders_.at(folder / member);
        const auto stamp = file_stamp(folder / member);
        note(entry, folder, {.name = member, .stamp = stamp.value_or(FileStamp{})});
        entry.marks.push_back(entry.mark);
        entry.bytes += contents.bytes;
        entry.changed = std::max(entry.changed, contents.changed_ns / 1'000'000);
        entry.writing = entry.writing || now_ns_ - contents.changed_ns < kQuietNs;
        if (!entry.writing) ++entry.settled;
      }
    }
  }

  void add_step(const fs::path& source, FileKind kind, const fs::path& folder, const std::vector<const LookedAt*>& members) {
    FolderEntry* entry = add(source, kind, folder, members);
    if (entry && members.size() == 1) add_listed(*entry, folder, *members.front());
  }

  bool is_being_written(const fs::path& folder, const std::vector<const LookedAt*>& files) const {
    return !writing_.empty() && std::any_of(files.begin(), files.end(), [&](const LookedAt* file) { return writing_.contains((folder / file->name).string()); });
  }

  void list_case(const fs::path& folder, const FolderContents& contents) {
    FolderEntry* entry = add(folder, FileKind::openfoam, folder, {});
    if (!entry) return;
    entry->files = 1;
    entry->bytes = contents.bytes;
    for (const LookedAt& time : contents.files) {
      entry->changed = std::max(entry->changed, time.stamp.changed_ns / 1'000'000);
      entry->mark = mark_of(entry->mark, time.name, {});  // fields are added to a time that is there
      entry->marks.push_back(entry->mark);
      entry->writing = entry->writing || now_ns_ - time.stamp.changed_ns < kQuietNs;
      if (!entry->writing) ++entry->settled;
    }
    entry->changed = std::max(entry->changed, contents.changed_ns / 1'000'000);
  }

  void list_levels(const fs::path& folder, const FolderContents& contents) {
    FolderEntry* entry = add(folder, *contents.dataset, folder, {});
    if (!entry) return;
    entry->files = 1;
    for (const LookedAt& file : contents.files) {
      note(*entry, folder, file);
      entry->writing = entry->writing || now_ns_ - file.stamp.changed_ns < kQuietNs;
    }
    entry->writing = entry->writing || now_ns_ - contents.changed_ns < kQuietNs;  // a chunk, too
    entry->bytes = contents.bytes;
    entry->mark = mark_of(entry->mark, "", {.bytes = contents.bytes, .changed_ns = contents.changed_ns});
    entry->changed = std::max(entry->changed, contents.changed_ns / 1'000'000);
    entry->settled = !entry->writing;
  }

  using Group = std::pair<std::string, std::vector<const LookedAt*>>;  // a name or a pattern, and its files in the order of their numbers
  static std::vector<Group> grouped(const std::vector<const LookedAt*>& files) {  // by name
    const auto by_name = [](const LookedAt* file, const std::string& name) { return file->name < name; };
    std::vector<std::string> names;
    for (const LookedAt* file : files) names.push_back(file->name);
    std::vector<Group> out;
    for (NameGroup& group : group_by_number(std::move(names))) {
      std::vector<const LookedAt*> members;
      for (const std::string& member : group.members) members.push_back(*std::lower_bound(files.begin(), files.end(), member, by_name));
      out.emplace_back(std::move(group.name), std::move(members));
    }
    return out;
  }

  void list_pictures(const fs::path& folder, const std::vector<const LookedAt*>& pictures) {
    for (const auto& [name, members] : grouped(pictures)) {
      std::optional<std::pair<int, int>> size;
      bool alike = true;
      for (const LookedAt* file : members) {
        if (size && file->picture && *size != *file->picture) alike = false;
        if (file->picture) size = file->picture;
      }
      if (members.size() >= kLeastSlices && alike) {
        add(folder / name, FileKind::pictures, folder, members);
        continue;
      }
      for (const LookedAt* file : members) {
        if (ends_with_one_of(small_letters(file->name), ".tif .tiff"))
          add(folder / file->name, FileKind::tiff, folder, {file});  // its pages may be slices
        else
          pass_over(folder, file->name,
                    alike ? "one picture; a stack of at least 3 numbered ones is listed as a volume" : "one of pictures of several sizes; the slices of a volume have one");
      }
    }
  }

  const fs::path& root_;
  const Folders& folders_;
  const std::int64_t now_ns_ = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  const std::set<std::string>& pieces_;
  const std::set<std::string>& writing_;
  std::map<std::string, PassedOver> passed_;
  FolderLister::Part out_;
};

std::int64_t count_of(const FolderContents& contents) {
  return static_cast<std::int64_t>(contents.files.size() + contents.folders.size() + contents.passed_over.size());
}

}  // namespace

void PassedOverSum::add(const std::vector<PassedOver>& some) {
  for (const PassedOver& passed : some) {
    PassedOver& all = by_reason_[passed.reason];
    all.reason = passed.reason;
    all.files += passed.files;
    for (const std::string& example : passed.examples)
      if (all.examples.size() < 3) all.examples.push_back(example);
  }
}

std::vector<PassedOver> PassedOverSum::most_first() const {
  std::vector<PassedOver> out;
  for (const auto& [reason, passed] : by_reason_) out.push_back(passed);
  std::stable_sort(out.begin(), out.end(), [](const PassedOver& a, const PassedOver& b) { return a.files > b.files; });
  return out;
}

void FolderLister::forget(const fs::path& folder) {
  const std::string below = folder.string() + "/";
  for (auto it = folders_.lower_bound(folder); it != folders_.end() && (it->first == folder || it->first.native().starts_with(below));) {
    renewed_.insert(it->first);
    parts_.erase(it->first);
    seen_ -= count_of(it->second);
    it = folders_.erase(it);
  }
}

void FolderLister::look(const fs::path& folder, int depth) {
  if (is_part_of_case(folder)) return look(folder.parent_path(), depth - 1);  // a new time, perhaps
  const auto known = folders_.find(folder);
  const std::int64_t before = known == folders_.end() ? 0 : count_of(known->second);
  std::optional<FolderContents> contents = look_at_folder(folder, root_, kMostListed - seen_ + before, known == folders_.end() ? nullptr : &known->second);
  if (!contents) return forget(folder);
  seen_ += count_of(*contents) - before;
  renewed_.insert(folder);
  const std::vector<std::string> gone_before = known == folders_.end() ? std::vector<std::string>{} : known->second.folders;
  FolderContents& now = folders_[folder] = std::move(*contents);
  for (const std::string& inner : gone_before)
    if (!std::binary_search(now.folders.begin(), now.folders.end(), inner)) forget(folder / inner);
  for (const std::string& inner : std::vector<std::string>(now.folders)) {
    if (now.dataset == FileKind::openfoam) {
      if (folders_.try_emplace(folder / inner).second) renewed_.insert(folder / inner);  // nothing is listed of it, but its times are followed
    } else if (depth + 1 > kMaxDepth)
      cut_off_ = true;
    else if (everything_ || !folders_.contains(folder / inner))
      look(folder / inner, depth + 1);
  }
}

bool FolderLister::is_part_of_case(const fs::path& folder) const {
  const auto around = folders_.find(folder.parent_path());
  return folder != root_ && around != folders_.end() && around->second.dataset == FileKind::openfoam;
}

/// A file that another one names is that one's, wherever it lies below the folder.
void FolderLister::refer(const fs::path& folder, const std::string& name, std::set<std::string>& pieces) const {
  const fs::path path = (folder / name).lexically_normal();
  if (name.find('*') == std::string::npos) {
    pieces.insert(path.string());
    return;
  }
  try {
    for (const SeriesFile& file : series_files(path)) pieces.insert(file.path.string());
  } catch (const Error&) {
  }
}

std::set<fs::path> FolderLister::renew(const std::set<std::string>& writing) {
  if (everything_ || folders_.empty()) {
    everything_ = true;
    cut_off_ = false;
    look(root_, 0);
  } else {
    for (const fs::path& folder : stale_)
      if (folders_.contains(folder)) look(folder, static_cast<int>(std::distance(folder.begin(), folder.end()) - std::distance(root_.begin(), root_.end())));
  }
  stale_.clear();
  everything_ = folders_.empty();
  if (!renewed_.empty()) {
    std::set<std::string> pieces;
    for (const auto& [folder, contents] : folders_)
      for (const LookedAt& file : contents.files) {
        for (const std::string& name : file.refers_to) refer(folder, name, pieces);
        if (!file.refers_to.empty()) renewed_.insert(folder);  // what it lists may be another
      }
    std::vector<std::string> others;
    std::set_symmetric_difference(pieces.begin(), pieces.end(), pieces_.begin(), pieces_.end(), std::back_inserter(others));
    for (const std::string& piece : others)
      if (const fs::path folder = fs::path(piece).parent_path(); folders_.contains(folder)) renewed_.insert(folder);
    pieces_ = std::move(pieces);
  }
  for (const fs::path& folder : std::set<fs::path>(renewed_)) {  // a plotfile is listed by the folder around it; what is gone may have been one
    const auto at = folders_.find(folder);
    if (folder != root_ && (at == folders_.end() || at->second.dataset == FileKind::amrex)) renewed_.insert(folder.parent_path());
  }
  for (const fs::path& folder : renewed_)
    if (const auto at = folders_.find(folder); at != folders_.end()) {
      parts_[folder] = Listing(root_, folders_, pieces_, writing).run(folder);
      cut_off_ = cut_off_ || at->second.cut_off;
    }
  cut_off_ = cut_off_ || seen_ >= kMostListed;
  std::set<fs::path> renewed = std::move(renewed_);
  renewed_.clear();
  if (folders_.empty()) throw Error(ErrorCode::not_found, root_.string() + ": this directory cannot be listed");
  return renewed;
}

FolderListing FolderLister::list(const std::set<std::string>& writing, std::size_t most) {
  renew(writing);
  FolderListing out;
  PassedOverSum passed_over;
  for (const auto& [folder, part] : parts_) {
    out.entries.insert(out.entries.end(), part.entries.begin(), part.entries.end());
    passed_over.add(part.passed_over);
  }
  std::sort(out.entries.begin(), out.entries.end(), [](const FolderEntry& a, const FolderEntry& b) { return a.name < b.name; });
  out.cut_off = cut_off_ || out.entries.size() > most;
  if (out.entries.size() > most) out.entries.resize(most);
  out.passed_over = passed_over.most_first();
  return out;
}

FolderListing list_folder(const fs::path& folder, std::size_t most) {
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  if (!error) fs::directory_iterator(root, error);
  if (error) throw Error(ErrorCode::not_found, folder.string() + ": this directory cannot be listed: " + error.message());
  return FolderLister(root).list({}, most);
}

}  // namespace isostrata
