#include "engine/data/catalogue.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>

#include "base/error.h"
#include "base/utf8.h"
#include "data/analytic.h"
#include "data/beneath.h"
#include "data/file_series.h"
#include "data/recognise.h"

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

/// A file below the root, so that what is put in its place later cannot lead out of it. Of numbered files, which are many, the plain path.
std::string marked(const fs::path& root, const fs::path& file) {
  const fs::path rest = file.lexically_relative(root);
  const bool inside_root = !rest.empty() && *rest.begin() != "..";
  return inside_root && !is_series_pattern(file) ? beneath(root, rest).string() : file.string();
}

/// A file or the pattern of a series, with what is known of it. Whether it can be opened shows when it is.
CatalogueEntry entry_of(const fs::path& path) {
  CatalogueEntry entry;
  entry.name = path.filename().string();
  fs::path first = path;
  if (is_series_pattern(path)) {
    const std::vector<SeriesFile> files = series_files(path);
    first = files.front().path;
    entry.files = static_cast<int>(files.size());
    entry.source = (fs::canonical(first).parent_path() / path.filename()).string();
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
  return entry;
}

}  // namespace

void Catalogue::add(CatalogueEntry entry) {
  const std::string plain = without_mark(entry.source).string();
  if (entries_.size() >= kMaxEntries || !sources_.insert(plain).second) return;
  entry.id = is_analytic(plain) ? plain : id_of(entry.name, plain);
  std::replace(entry.id.begin(), entry.id.end(), ':', '-');
  const std::string stem = entry.id;
  for (int n = 2; find(entry.id); ++n) entry.id = stem + "-" + std::to_string(n);
  entry.name = valid_utf8(entry.name);
  place_of_[entry.id] = entries_.size();
  entries_.push_back(std::move(entry));
}

void Catalogue::add_directory(const fs::path& directory) {
  FolderListing listing = list_folder(directory, kMaxEntries);
  const fs::path root = fs::canonical(directory);
  for (FolderEntry& entry : listing.entries) {
    entry.source = marked(root, entry.source);
    add({{}, std::move(entry.name), std::move(entry.source), std::string(format_of(entry.kind).name), entry.bytes, entry.changed, entry.files});
  }
  for (PassedOver& passed : listing.passed_over) {
    const auto same = std::find_if(passed_over_.begin(), passed_over_.end(), [&](const PassedOver& other) { return other.reason == passed.reason; });
    if (same == passed_over_.end())
      passed_over_.push_back(std::move(passed));
    else
      same->files += passed.files;
  }
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
      catalogue.add(entry_of(source));
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
