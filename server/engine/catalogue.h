// What may be opened. Clients name datasets by opaque ids and never send a path.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace isostrata {

struct CatalogueEntry {
  std::string id;      // short, stable for the same source within one server's life: "bluntfinxyz-3f2a91"
  std::string name;    // what a person reads: the file's name as valid_utf8, or of analytic data its name
  std::string source;  // what open_dataset takes; stays on the server
};

/// Immutable once made.
class Catalogue {
 public:
  /// Each source is a file, a directory (its readable files at any depth, at most 10000, sorted; hidden ones and links out of it
  /// are left out) or the name of analytic data. Throws not_found where a source is none of these, or cannot be listed.
  static Catalogue from_sources(const std::vector<std::string>& sources);
  /// Of entries that another catalogue gave; no file is looked at.
  static Catalogue from_entries(std::vector<CatalogueEntry> entries);
  /// The built-in analytic scenes.
  static Catalogue analytic();

  /// The most entries that one has; what is beyond them is left out.
  static constexpr std::size_t kMaxEntries = 10000;
  const std::vector<CatalogueEntry>& entries() const { return entries_; }
  /// Null where there is none of that id.
  const CatalogueEntry* find(std::string_view id) const;

 private:
  void add(std::string name, std::string source);
  void add_directory(const std::filesystem::path& directory);

  std::vector<CatalogueEntry> entries_;
  std::map<std::string, std::size_t, std::less<>> place_of_;  // of an id, in entries_
  std::set<std::string> sources_;
};

}  // namespace isostrata
