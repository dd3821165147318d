// What of a folder can be opened, what was passed over, and why.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "data/files/file_formats.h"
#include "data/files/file_series.h"
#include "data/files/look_at_folder.h"

namespace isostrata {

struct FolderEntry {
  std::string name;    // below the folder: a file, a pattern of numbered ones, or a folder that is one data set
  std::string source;  // what open_dataset takes
  FileKind kind = FileKind::vtk_legacy;
  std::uint64_t bytes = 0;   // of all its files
  std::int64_t changed = 0;  // when the newest of them was, in milliseconds since 1970
  int files = 1;             // steps or slices that are files of their own; of a folder that is one data set, 1
  EqualSteps numbers{};      // in the names of these
  // Of its numbered files, of those that it lists, of the times of an OpenFOAM case: what mark_of gives for the first, for the first two and so on. The data set
  // has grown if what it had is the beginning of what it has. Empty if it is one file.
  std::vector<std::uint64_t> marks{};
  std::uint64_t mark = 0;  // what mark_of gives for all that it is made of
  bool writing = false;    // one of its files is being written
  int settled = 1;         // of `marks`, those before the first that is; 1 of a single file that nobody writes
};

struct PassedOver {
  std::string reason;                 // "a surface; expected a grid whose cells have a volume"
  std::int64_t files = 0;
  std::vector<std::string> examples;  // at most 3
};

struct FolderListing {
  std::vector<FolderEntry> entries;     // in the order of their names
  std::vector<PassedOver> passed_over;  // most files first
  bool cut_off = false;                 // there are more entries than `most`, or more files than are looked at
};

/// Looks at the first bytes of each file at any depth up to 8. Numbered files are one entry (file_series.h); files that another one lists (pieces, parts, the data of a
/// header) are that one's; a file of a format that is read is an entry also if it is damaged, so that opening it says why. Links that lead out of the folder
/// are passed over. Throws not_found if the folder cannot be listed.
FolderListing list_folder(const std::filesystem::path& folder, std::size_t most = 10'000);

/// Adds up files that were passed over for the same reason, with at most three examples of each.
class PassedOverSum {
 public:
  void add(const std::vector<PassedOver>& some);
  std::vector<PassedOver> most_first() const;

 private:
  std::map<std::string, PassedOver> by_reason_;
};

/// The same of one folder again and again: what has not changed is not opened again, and not listed again. Not thread-safe.
class FolderLister {
 public:
  /// What one folder below the root adds to the listing.
  struct Part {
    std::vector<FolderEntry> entries;
    std::vector<PassedOver> passed_over;
  };

  /// The folder's real path must not be empty; it may be gone at times.
  explicit FolderLister(std::filesystem::path root) : root_(std::move(root)) {}

  /// Nothing of this folder is believed any more: its names are read again, and files that are not as they were are looked at. A folder that is not known, too.
  void look_again(const std::filesystem::path& folder) { stale_.insert(folder); }
  void look_again_everywhere() { everything_ = true; }

  /// Looks at what is not believed. Gives the folders whose parts are others than before, or gone. writing: files that are being written. Throws not_found where
  /// the root itself cannot be listed.
  std::set<std::filesystem::path> renew(const std::set<std::string>& writing = {});
  const std::map<std::filesystem::path, Part>& parts() const { return parts_; }
  bool cut_off() const { return cut_off_; }

  /// All parts as one listing, after renew.
  FolderListing list(const std::set<std::string>& writing = {}, std::size_t most = 10'000);

 private:
  void look(const std::filesystem::path& folder, int depth);
  bool is_part_of_case(const std::filesystem::path& folder) const;
  void forget(const std::filesystem::path& folder);
  void refer(const std::filesystem::path& folder, const std::string& name, std::set<std::string>& pieces) const;

  const std::filesystem::path root_;
  std::map<std::filesystem::path, FolderContents> folders_;
  std::map<std::filesystem::path, Part> parts_;
  std::set<std::string> pieces_;  // files that are others'
  std::set<std::filesystem::path> stale_, renewed_;
  bool everything_ = true;
  bool cut_off_ = false;
  std::int64_t seen_ = 0;
};

}  // namespace isostrata
