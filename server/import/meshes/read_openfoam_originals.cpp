#include <set>
#include <string>
#include <string_view>
#include <system_error>

#include "data/files/openfoam_case.h"
#include "import/meshes/openfoam_originals.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLinks = "case";
constexpr std::string_view kEnd = ".orig";
constexpr int kMostOriginals = 100'000;

bool is_original(const fs::path& file) {
  std::error_code error;
  return file.native().ends_with(kEnd) && fs::exists(file.native().substr(0, file.native().size() - kEnd.size()), error);
}

bool has_originals(const fs::path& time) {
  std::error_code error;
  for (fs::directory_iterator it(time, error), end; !error && it != end; it.increment(error))
    if (is_original(it->path())) return true;
  return false;
}

}  // namespace

void make_links_without_originals(const ReadRequest& request) {
  std::error_code error;
  const bool mark = request.file.extension() == ".foam" || request.file.extension() == ".openfoam";
  const fs::path folder = fs::is_directory(request.file, error) ? request.file : mark ? request.file.parent_path() : fs::path();
  if (folder.empty() || !fs::is_regular_file(folder / "system" / "controlDict", error) || !openfoam_parts(folder).empty()) return;
  std::set<std::string> times;
  for (const auto& [time, name] : openfoam_times(folder))
    if (has_originals(folder / name)) times.insert(name);
  if (times.empty()) return;
  int left = kMostOriginals;
  const auto link_all = [&](const fs::path& from, const fs::path& to, const auto& but) {
    fs::create_directories(to, error);
    for (fs::directory_iterator it(from, error), end; !error && it != end && --left > 0; it.increment(error))
      if (std::error_code ignored; !but(it->path())) fs::create_symlink(it->path(), to / it->path().filename(), ignored);
  };
  link_all(folder, request.scratch / kLinks, [&](const fs::path& path) { return times.contains(path.filename().string()); });
  for (const std::string& time : times) link_all(folder / time, request.scratch / kLinks / time, is_original);
}

fs::path case_without_originals(const fs::path& folder, const ReadRequest& request) {
  std::error_code error;
  return fs::is_directory(request.scratch / kLinks, error) ? request.scratch / kLinks : folder;
}

void remove_links_without_originals(const ReadRequest& request) {
  std::error_code error;
  fs::remove_all(request.scratch / kLinks, error);
}

}  // namespace isostrata
