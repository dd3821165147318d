#include "engine/data/catalogue.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>

#include "base/error.h"
#include "base/utf8.h"
#include "data/dataset/analytic.h"
#include "data/files/beneath.h"
#include "data/files/file_series.h"
#include "data/files/look_at_folder.h"
#include "data/files/recognise.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
// FNV-1a: only to keep ids apart, so nothing depends on its strength.
std::uint32_t hash_of(std::string_view text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

std::string id_of(const std::string& name, const std::string& source) {
  std::string id;
  for (const char c : fs::path(name).stem().string()) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u) && u < 128)
      id += static_cast<char>(std::tolower(u));
    else if (!id.empty() && id.back() != '-')
      id += '-';
    if (id.size() >= 40) break;
  }
  while (!id.empty() && id.back() == '-') id.pop_back();
  std::array<char, 16> hash{};
  std::snprintf(hash.data(), hash.size(), "%s%06x", id.empty() ? "" : "-", hash_of(source) & 0xffffffu);
  return id + hash.data();
}

/// The first id for the entry that is not taken.
template <class Taken>
std::string free_id(const CatalogueEntry& entry, const Taken& taken) {
  const std::string plain = without_mark(entry.source).string();
  std::string stem = is_analytic(plain) ? plain : id_of(entry.name, plain);
  std::replace(stem.begin(), stem.end(), ':', '-');
  std::string id = stem;
  for (int n = 2; taken(id); ++n) id = stem + "-" + std::to_string(n);
  return id;
}

/// A file, or the pattern of files, below the root, so that what is put in their place later cannot lead out of it.
std::string marked(const fs::path& root, const fs::path& file) {
  const std::string& text = file.native();  // most are plainly below it, and there are many
  if (const auto length = root.native().size(); length > 1 && text.size() > length + 1 && text.starts_with(root.native()) && text[length] == '/')
    return text.substr(0, length) + "/." + text.substr(length);
  const fs::path rest = file.lexically_relative(root);
  const bool inside_root = !rest.empty() && *rest.begin() != "..";
  return inside_root ? beneath(root, rest).string() : file.string();
}

/// Of a pattern that somebody has named: its files may be links out of their folder from the start, and are then meant.
fs::path marked_pattern(const fs::path& pattern) {
  const fs::path folder = fs::canonical(pattern.parent_path());
  const fs::path inside = beneath(folder, pattern.filename());
  try {
    series_files(inside);
    return inside;
  } catch (const Error&) {
    return folder / pattern.filename();
  }
}

}  // namespace

std::string version_id(const CatalogueEntry& entry) { return entry.version == 0 ? entry.id : entry.id + "~" + std::to_string(entry.version); }
std::string plain_id(const std::string& id) { return id.substr(0, id.rfind('~')); }

std::string whole_id(const std::string& id) {
  const auto at = id.find('@'), version = id.rfind('~');
  if (at == std::string::npos) return id;
  return id.substr(0, at) + (version == std::string::npos ? "" : id.substr(version));
}

std::string part_id(const std::string& id, const Region& part) {
  const std::string whole = whole_id(id);
  if (part == Region{}) return whole;
  const auto version = std::min(whole.rfind('~'), whole.size());
  return whole.substr(0, version) + '@' + to_string(part) + whole.substr(version);
}

std::string with_part_of(const std::string& like, const std::string& whole) {
  const std::string plain = plain_id(like);
  const auto at = plain.find('@');
  if (at == std::string::npos) return whole;
  const auto version = std::min(whole.rfind('~'), whole.size());
  return whole.substr(0, version) + plain.substr(at) + whole.substr(version);
}

Region part_of_id(const std::string& id) {
  const std::string plain = plain_id(id);
  const auto at = plain.find('@');
  return at == std::string::npos ? Region{} : region_of(std::string_view(plain).substr(at + 1));
}

std::string part_name(const std::string& name, const Region& part) {
  if (part == Region{}) return name;
  Region box = part;
  box.stride = Region{}.stride;
  std::string text = name + ", points " + to_string(box);
  if (part.stride != box.stride) text += " by " + to_string(part).substr(to_string(part).find('*') + 1);
  return text;
}

/// Whether it can be opened shows when it is.
CatalogueEntry Catalogue::entry_of(const fs::path& path) {
  CatalogueEntry entry;
  entry.name = path.filename().string();
  fs::path first = path;
  if (is_series_pattern(path)) {
    const std::vector<SeriesFile> files = series_files(path);
    first = files.front().path;
    entry.files = static_cast<int>(files.size());
    std::vector<std::string> names;
    for (const SeriesFile& file : files) names.push_back(file.path.filename().string());
    entry.numbers = equal_steps(entry.name, names);
    entry.source = marked_pattern(fs::absolute(path)).string();
  } else {
    const fs::path real = fs::canonical(path);
    entry.source = marked(real.parent_path(), real);
  }
  try {
    entry.kind = format_of(is_series_pattern(path) && names_pictures(path) ? FileKind::pictures : recognise(first).kind).name;
  } catch (const Error&) {
  }
  const SourceStamp stamp = stamp_of(path);
  entry.bytes = stamp.bytes;
  entry.changed_unix_ms = stamp.changed_unix_ms();
  entry.one_step = is_series_pattern(path) && (names_pictures(path) || entry.kind == format_of(FileKind::dicom).name);
  entry.parts = entry.files;
  entry.mark = mark_on_disk(entry.source, entry.files);
  return entry;
}

CatalogueEntry Catalogue::entry_of(const fs::path& root, const FolderEntry& listed) {
  CatalogueEntry entry{{}, listed.name, marked(root, listed.source), std::string(format_of(listed.kind).name), listed.bytes, listed.changed, listed.files};
  const bool slices = listed.kind == FileKind::pictures || listed.kind == FileKind::dicom;
  const bool lists_steps = listed.kind == FileKind::pvd || listed.kind == FileKind::series || listed.kind == FileKind::openfoam;
  entry.one_step = slices || (listed.files <= 1 && !lists_steps);
  entry.writing = listed.writing;
  entry.numbers = listed.numbers;
  entry.parts = std::max(1, static_cast<int>(listed.marks.size()));
  // What a reader may find otherwise than it was listed: of lists, cases and folders too much to look at again after each reading.
  const bool numbered = listed.files > 1 && is_series_pattern(listed.source);
  entry.mark = numbered || listed.marks.empty() ? listed.mark : 0;
  if (listed.kind == FileKind::openfoam || listed.kind == FileKind::zarr || listed.kind == FileKind::amrex || (listed.kind == FileKind::dicom && listed.files > 1)) entry.mark = 0;
  return entry;
}

namespace {

/// Of a catalogue that follows nothing: whoever opens a file later gets what is there then.
CatalogueEntry unmarked(CatalogueEntry entry) {
  entry.mark = 0;
  return entry;
}

}  // namespace

const CatalogueEntry* Catalogue::add(CatalogueEntry entry) {
  if (entries_.size() >= kMaxEntries) {
    cut_off_ = true;
    return nullptr;
  }
  if (!sources_.insert(without_mark(entry.source).string()).second) return nullptr;
  if (entry.id.empty()) entry.id = free_id(entry, [this](const std::string& id) { return find(id) != nullptr; });
  entry.name = valid_utf8(entry.name);
  place_of_[entry.id] = entries_.size();
  entries_.push_back(std::move(entry));
  return &entries_.back();
}

void Catalogue::put(CatalogueEntry entry) {
  entry.name = valid_utf8(entry.name);
  const auto [at, is_new] = place_of_.try_emplace(entry.id, entries_.size());
  if (is_new)
    entries_.push_back(std::move(entry));
  else
    entries_[at->second] = std::move(entry);
}

void Catalogue::reserve(std::size_t entries) {
  entries_.reserve(entries);
  place_of_.reserve(entries);
}

std::string Catalogue::new_id(const CatalogueEntry& entry, std::unordered_set<std::string>& given) {
  return free_id(entry, [&given](const std::string& id) { return !given.insert(id).second; });
}

void Catalogue::pass_over(const std::vector<PassedOver>& all) {
  for (const PassedOver& passed : all) {
    const auto same = std::find_if(passed_over_.begin(), passed_over_.end(), [&](const PassedOver& other) { return other.reason == passed.reason; });
    if (same == passed_over_.end())
      passed_over_.push_back(passed);
    else
      same->files += passed.files;
  }
}

void Catalogue::add_directory(const fs::path& directory) {
  const FolderListing listing = list_folder(directory, kMaxEntries);
  const fs::path root = fs::canonical(directory);
  for (const FolderEntry& entry : listing.entries) add(unmarked(entry_of(root, entry)));
  cut_off_ = cut_off_ || listing.cut_off;
  pass_over(listing.passed_over);
}

Catalogue Catalogue::from_sources(const std::vector<std::string>& sources) {
  Catalogue catalogue;
  for (const std::string& source : sources) {
    std::error_code error;
    if (is_analytic(source))
      catalogue.add({{}, source, source});
    else if (fs::is_directory(source, error))
      catalogue.add_directory(source);
    else if (fs::is_regular_file(source, error) || is_series_pattern(source))
      catalogue.add(unmarked(entry_of(source)));
    else
      throw Error(ErrorCode::not_found, source +
                                            ": no such file or directory, and not the name of analytic data "
                                            "(torus, sphere, marschner-lobb, cylinder, implicit-flow, tets, mixed, diamond)");
  }
  return catalogue;
}

Catalogue Catalogue::from_entries(std::vector<CatalogueEntry> entries) {
  Catalogue catalogue;
  catalogue.entries_ = std::move(entries);
  for (std::size_t i = 0; i < catalogue.entries_.size(); ++i) {
    catalogue.place_of_[catalogue.entries_[i].id] = i;
    catalogue.sources_.insert(catalogue.entries_[i].source);
  }
  return catalogue;
}

// Sizes that a software renderer still turns smoothly; a larger one is a matter of naming it: `isostrata serve torus:256`.
Catalogue Catalogue::analytic() {
  return from_sources(
      {"torus:32", "sphere:32", "marschner-lobb:40", "cylinder:48x32x16", "implicit-flow:32", "tets:16", "mixed:17"});
}

const CatalogueEntry* Catalogue::find(std::string_view id) const {
  const auto it = place_of_.find(id);
  return it == place_of_.end() ? nullptr : &entries_[it->second];
}

}  // namespace isostrata
