// One folder as it lies on the disk: what each file is, by its first bytes. list_folder.h makes the listing of it.
#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/files/recognise.h"

namespace isostrata {

/// By which a file is known to be the same as before: one that is replaced by another of its size has another number or another time.
struct FileStamp {
  std::uint64_t bytes = 0;
  std::int64_t changed_ns = 0;  // since 1970
  std::uint64_t inode = 0;
  bool operator==(const FileStamp&) const = default;
};

FileStamp stamp_of(const struct stat& about);

/// Of what stands at the path, links followed; nothing if nothing does.
std::optional<FileStamp> file_stamp(const std::filesystem::path& file);

/// A number for one more file behind those that `before` stands for. 0 stands for none.
std::uint64_t mark_of(std::uint64_t before, const std::string& name, const FileStamp& stamp);

/// What mark_of gives for all of them: of a file, of the first `files` of a pattern's files; 0 of a folder and of what is not there.
std::uint64_t mark_on_disk(const std::filesystem::path& source, int files);

struct LookedAt {
  enum class Use : std::uint8_t { open, dicom, picture, none };
  std::string name;
  FileStamp stamp;
  Use use = Use::none;
  Recognised of{};                                       // of what can be opened
  std::string why_not{};                                 // of what cannot
  std::optional<std::pair<int, int>> picture{};          // its columns and rows, where it says them
  std::vector<std::string> refers_to{};                  // files that it lists; in a * any number
};

struct FolderContents {
  std::optional<FileKind> dataset{};  // the folder is one: `files` are then the times of an OpenFOAM case, in their order, or what is followed of Zarr and of a plotfile; `folders` is empty, but for those of processors in which a case has its times
  std::int64_t changed_ns = 0;        // the folder itself; of Zarr the newest of what is counted in `bytes`
  std::uint64_t bytes = 0;            // of a folder that is one: of all files below it; 0 if these are more than 10,000
  std::vector<LookedAt> files;        // in the order of their names
  std::vector<std::string> folders;   // the same
  std::vector<std::pair<std::string, std::string>> passed_over;  // names with reasons: what is not a file
  bool cut_off = false;               // there are more than `most`

  /// Null if there is no file of that name.
  const LookedAt* find(const std::string& name) const;
};

/// Files that `before` has with the same stamp are not opened again. Links that lead out of `root`, a real path, are passed over. Nothing if the folder cannot be listed.
std::optional<FolderContents> look_at_folder(const std::filesystem::path& folder, const std::filesystem::path& root, std::int64_t most,
                                             const FolderContents* before);

}  // namespace isostrata
