// What of a folder can be opened, what was passed over, and why.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "data/file_formats.h"

namespace isostrata {

struct FolderEntry {
  std::string name;    // below the folder: a file, a pattern of numbered ones, or a folder that is one data set
  std::string source;  // what open_dataset takes
  FileKind kind = FileKind::vtk_legacy;
  std::uint64_t bytes = 0;   // of all its files
  std::int64_t changed = 0;  // when the newest of them was, in milliseconds since 1970
  int files = 1;             // steps or slices that are files of their own; of a folder that is one data set, 1
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
/// header) are that one's; a file of a format that is read is an entry also where it is damaged, so that opening it says why. Links that lead out of the folder
/// are passed over. Throws not_found where the folder cannot be listed.
FolderListing list_folder(const std::filesystem::path& folder, std::size_t most = 10'000);

}  // namespace isostrata
