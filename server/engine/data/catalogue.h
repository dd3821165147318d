// What may be opened. Clients name datasets by opaque ids and never send a path.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "data/files/list_folder.h"
#include "data/parts/region.h"

namespace isostrata {

/// What was noticed of an entry since the server began (living_catalogue.h).
enum class CatalogueNews : std::uint8_t { none, appeared, grown, changed, gone };

struct CatalogueEntry {
  std::string id;      // short, stable for the same source within one server's life: "bluntfinxyz-3f2a91"
  std::string name;    // what a person reads: the file's name as valid_utf8, or of analytic data its name
  std::string source;  // what open_dataset takes, a file as data/files/beneath.h has it; stays on the server
  std::string kind = {};             // "NIfTI"; of analytic data empty
  std::uint64_t bytes = 0;           // of all its files
  std::int64_t changed_unix_ms = 0;  // the newest of them
  int files = 1;                     // steps or slices that are files of their own
  bool one_step = false;             // its files are parts of one step (slices, blocks, boxes, pieces), else steps
  bool writing = false;              // one of its files is being written
  CatalogueNews news = CatalogueNews::none;
  std::int64_t noticed_unix_ms = 0;  // when
  // Counts contents: one more if what had been there was rewritten, removed or put into another order. Steps that follow at the end change nothing of it.
  std::uint32_t version = 0;
  EqualSteps numbers{};    // in the names of its files
  int parts = 1;           // of this version that are complete: numbered files, files of a list, times of an OpenFOAM case
  std::uint64_t mark = 0;  // mark_on_disk of the source with so many files, which whoever has read it compares; 0: nothing is known
};

/// The id of one version of an entry, by which an engine knows it: "plume-3f2a91~2"; of version 0 the entry's own.
std::string version_id(const CatalogueEntry& entry);
/// The entry's own of such an id.
std::string plain_id(const std::string& id);

/// The id of a part of an entry, which is opened as a dataset of its own: "head-3f2a91@0:63,:,:*2"; its versions are "head-3f2a91@0:63,:,:*2~2". Of everything
/// it is the entry's. An id that has a part already gets this one in its place.
std::string part_id(const std::string& id, const Region& part);
/// The entry's own of the id of a part, of a version or of none.
std::string whole_id(const std::string& id);
/// The id of `whole`, or of one of its versions, with the part that the text `like` has behind its '@'. Nobody has judged that text yet.
std::string with_part_of(const std::string& like, const std::string& whole);
/// The part; of everything Region{}. Throws invalid_argument.
Region part_of_id(const std::string& id);
/// What a person reads: "head, points 0:63,:,: by 2".
std::string part_name(const std::string& name, const Region& part);

/// Immutable once made, but for those who make it.
class Catalogue {
 public:
  /// Each source is a file, the pattern of a series, a directory (what list_folder finds in it, or what it is itself: an OpenFOAM case, a Zarr image, slices of DICOM) or the
  /// name of analytic data. Throws not_found if a source is none of these, or cannot be listed.
  static Catalogue from_sources(const std::vector<std::string>& sources);
  /// Of entries that another catalogue gave; no file is looked at.
  static Catalogue from_entries(std::vector<CatalogueEntry> entries);
  /// The built-in analytic scenes.
  static Catalogue analytic();
  /// A file or the pattern of a series as an entry without an id. Throws not_found.
  static CatalogueEntry entry_of(const std::filesystem::path& path);
  /// One of a directory's listing, whose real path is `root`.
  static CatalogueEntry entry_of(const std::filesystem::path& root, const FolderEntry& listed);

  /// One more, under its id or else under a new one; passed over where the source is there already, or there are kMaxEntries. Null if it was.
  const CatalogueEntry* add(CatalogueEntry entry);
  /// In place of the one with its id, or one more.
  void put(CatalogueEntry entry);
  void reserve(std::size_t entries);
  /// One that is not among those that were given, which it then is: of the same name and source the same in the next server, but where several would have it.
  static std::string new_id(const CatalogueEntry& entry, std::unordered_set<std::string>& given);
  /// Those that are not as in the catalogue before this one, at most 20.
  const std::vector<CatalogueEntry>& latest() const { return latest_; }
  void set_latest(std::vector<CatalogueEntry> latest) { latest_ = std::move(latest); }
  void pass_over(const std::vector<PassedOver>& passed);
  void set_cut_off() { cut_off_ = true; }

  /// The most entries that one has; what is beyond them is left out.
  static constexpr std::size_t kMaxEntries = 200'000;
  const std::vector<CatalogueEntry>& entries() const { return entries_; }
  /// What the directories hold that is not offered, by reason.
  const std::vector<PassedOver>& passed_over() const { return passed_over_; }
  /// There is more in the directories than is looked at.
  bool cut_off() const { return cut_off_; }
  /// Null if there is none of that id.
  const CatalogueEntry* find(std::string_view id) const;

 private:
  struct TextHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>()(text); }
  };
  void add_directory(const std::filesystem::path& directory);

  std::vector<CatalogueEntry> entries_;
  std::vector<PassedOver> passed_over_;
  std::unordered_map<std::string, std::size_t, TextHash, std::equal_to<>> place_of_;  // of an id, in entries_
  std::vector<CatalogueEntry> latest_;
  std::set<std::string> sources_;
  bool cut_off_ = false;
};

}  // namespace isostrata
