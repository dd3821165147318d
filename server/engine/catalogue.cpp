#include "engine/catalogue.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>

#include "base/error.h"
#include "base/utf8.h"
#include "data/analytic.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
constexpr int kMaxDepth = 8;

// What isostrata-import opens as a dataset of its own. A PLOT3D solution is found beside its grid, so only grids are listed.
bool looks_readable(const fs::path& path) {
  static constexpr std::array kExtensions = {".vtk",  ".vti",  ".vtr", ".vts", ".vtu", ".pvti", ".pvtr", ".pvts", ".pvtu", ".pvd",
                                             ".nrrd", ".nhdr", ".mhd", ".slc", ".e",   ".ex2",  ".exo",  ".xyz",  ".p3d"};
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.ends_with("xyz.bin")) return true;
  return std::any_of(kExtensions.begin(), kExtensions.end(), [&](const char* extension) { return name.ends_with(extension); });
}

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

bool inside(const fs::path& path, const fs::path& directory) {
  const auto [end, at] = std::mismatch(directory.begin(), directory.end(), path.begin(), path.end());
  (void)at;
  return end == directory.end();
}

}  // namespace

void Catalogue::add(std::string name, std::string source) {
  if (entries_.size() >= kMaxEntries || !sources_.insert(source).second) return;
  std::string id = is_analytic(source) ? source : id_of(name, source);
  std::replace(id.begin(), id.end(), ':', '-');
  const std::string stem = id;
  for (int n = 2; find(id); ++n) id = stem + "-" + std::to_string(n);
  place_of_[id] = entries_.size();
  entries_.push_back({std::move(id), valid_utf8(name), std::move(source)});
}

void Catalogue::add_directory(const fs::path& directory) {
  std::error_code error;
  const fs::path root = fs::canonical(directory, error);
  if (!error) fs::directory_iterator(root, error);
  if (error) throw Error(ErrorCode::not_found, directory.string() + ": this directory cannot be listed: " + error.message());
  std::vector<fs::path> found;
  fs::recursive_directory_iterator it(root, fs::directory_options::skip_permission_denied, error), end;
  for (; !error && it != end && found.size() < kMaxEntries; it.increment(error)) {
    if (it->path().filename().string().starts_with('.')) {
      it.disable_recursion_pending();
      continue;
    }
    if (it.depth() >= kMaxDepth) it.disable_recursion_pending();
    std::error_code ignored;
    if (!it->is_regular_file(ignored) || !looks_readable(it->path())) continue;
    const fs::path real = fs::canonical(it->path(), ignored);
    if (!ignored && inside(real, root)) found.push_back(it->path());  // a link that leaves the directory is not offered
  }
  std::sort(found.begin(), found.end());
  for (const fs::path& path : found) add(path.lexically_relative(root).string(), path.string());
}

Catalogue Catalogue::from_sources(const std::vector<std::string>& sources) {
  Catalogue catalogue;
  for (const std::string& source : sources) {
    std::error_code error;
    if (is_analytic(source)) {
      catalogue.add(source, source);
    } else if (fs::is_directory(source, error)) {
      catalogue.add_directory(source);
    } else if (fs::is_regular_file(source, error)) {
      catalogue.add(fs::path(source).filename().string(), fs::canonical(source).string());
    } else {
      throw Error(ErrorCode::not_found, source +
                                            ": no such file or directory, and not the name of analytic data "
                                            "(torus, sphere, marschner-lobb, cylinder, implicit-flow, tets, mixed, diamond)");
    }
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
