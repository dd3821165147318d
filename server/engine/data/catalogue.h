// What may be opened. Clients name datasets by opaque ids and never send a path.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "data/list_folder.h"

namespace isostrata {

struct CatalogueEntry {
  std::string id;      // short, stable for the same source within one server's life: "bluntfinxyz-3f2a91"
  std::string name;    // what a person reads: the file's name as valid_utf8, or of analytic data its name
  std::string source;  // what open_dataset takes, a file as data/beneath.h has it; stays on the server
  std::string kind = {};             // "NIfTI"; of analytic data empty
  std::uint64_t bytes = 0;           // of all its files
  std::int64_t changed_unix_ms = 0;  // the newest of them
  int files = 1;                     // steps or slices that are files of their own
};

/// Immutable once made.
class Catalogue {
 public:
  /// Each source is a file, the pattern of a series, a directory (what list_folder finds in it, or what it is itself: an OpenFOAM case, slices of DICOM) or the
  /// name of analytic data. At most 10000. Throws not_found where a source is none of these, or cannot be listed.
  static Catalogue from_sources(const std::vector<std::string>& sources);
  /// Of entries that another catalogue gave; no file is looked at.
  static Catalogue from_entries(std::vector<CatalogueEntry> entries);
  /// The built-in analytic scenes.
  static Catalogue analytic();

  /// The most entries that one has; what is beyond them is left out.
  static constexpr std::size_t kMaxEntries = 10000;
  const std::vector<CatalogueEntry>& entries() const { return entries_; }
  /// What the directories hold that is not offered, by reason.
  const std::vector<PassedOver>& passed_over() const { return passed_over_; }
  /// Null where there is none of that id.
  const CatalogueEntry* find(std::string_view id) const;

 private:
  void add(CatalogueEntry entry);
  void add_directory(const std::filesystem::path& directory);

  std::vector<CatalogueEntry> entries_;
  std::vector<PassedOver> passed_over_;
  std::map<std::string, std::size_t, std::less<>> place_of_;  // of an id, in entries_
  std::set<std::string> sources_;
};

}  // namespace isostrata
