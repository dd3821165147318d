#include "data/files/openfoam_case.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <system_error>

#include "data/files/file_beginning.h"

namespace isostrata {

namespace fs = std::filesystem;

bool is_collated_name(const std::string& name) {
  return name.starts_with("processors") && name.size() > 10 && std::isdigit(static_cast<unsigned char>(name[10]));
}

std::map<double, std::string> openfoam_times(const fs::path& folder) {
  std::map<double, std::string> out;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    double time = 0;
    const auto [rest, bad] = std::from_chars(name.data(), name.data() + name.size(), time);
    std::error_code ignored;
    if (bad == std::errc{} && rest == name.data() + name.size() && std::isfinite(time) && it->is_directory(ignored)) out.emplace(time, name);
  }
  return out;
}

namespace {

/// A field on cells, also one of a collated file; what is packed may be one.
bool may_be_field(const fs::path& file) {
  if (file.extension() == ".gz") return true;
  const std::string head = file_beginning(file, 16384);
  for (auto at = head.find("class"); at != std::string::npos; at = head.find("class", at + 5))
    if (const auto word = head.find_first_not_of(" \t", at + 5); word != std::string::npos && head.compare(word, 3, "vol") == 0) return true;
  return false;
}

}  // namespace

bool has_fields_in_regions_alone(const fs::path& folder) {
  const auto times = openfoam_times(folder);
  if (times.empty()) return false;
  std::error_code error;
  for (fs::directory_iterator it(folder / std::prev(times.end())->second, error), end; !error && it != end; it.increment(error))
    if (std::error_code ignored; it->is_regular_file(ignored) && may_be_field(it->path())) return false;
  return !error;
}

std::vector<fs::path> openfoam_parts(const fs::path& folder) {
  std::vector<fs::path> parts;
  std::error_code error;
  for (fs::path next = folder / "processor0"; fs::is_directory(next, error); next = folder / ("processor" + std::to_string(parts.size()))) parts.push_back(next);
  if (parts.empty()) {
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
      if (std::error_code ignored; is_collated_name(it->path().filename().string()) && it->is_directory(ignored)) parts.push_back(it->path());
    std::sort(parts.begin(), parts.end());
  }
  if (parts.empty() || !fs::is_directory(folder / "constant" / "polyMesh", error)) return parts;
  const auto own = openfoam_times(folder), of_part = openfoam_times(parts.front());
  const bool begun = own.size() > own.count(0);  // 0 is where a run begins
  if (begun && (of_part.empty() || std::prev(own.end())->first >= std::prev(of_part.end())->first)) return {};
  return parts;
}

}  // namespace isostrata
