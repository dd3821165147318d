#include "data/files/zarr_folder.h"

#include <algorithm>
#include <array>
#include <string>
#include <system_error>

#include "data/files/beneath.h"
#include "data/files/file_beginning.h"
#include "data/files/recognise.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 5> kMetadata{".zarray", ".zattrs", ".zgroup", ".zmetadata", "zarr.json"};

/// Whether the text has a member of this name that is a list.
bool is_list(const std::string& text, std::string_view member) {
  const auto at = text.find(member);
  const auto value = at == std::string::npos ? at : text.find_first_not_of(" \t\r\n:", at + member.size());
  return value != std::string::npos && text[value] == '[';
}

/// Whether it is a group, one of whose first arrays names its axes, as xarray writes them.
bool names_axes_of_arrays(const fs::path& group) {
  std::error_code error;
  if (!fs::is_regular_file(group / ".zgroup", error) && !fs::is_regular_file(group / "zarr.json", error)) return false;
  int most = 64;
  for (fs::directory_iterator it(group, error), end; !error && it != end && --most > 0; it.increment(error))
    if (is_list(file_beginning(it->path() / ".zattrs"), "\"_ARRAY_DIMENSIONS\"") || is_list(file_beginning(it->path() / "zarr.json"), "\"dimension_names\"")) return true;
  return false;
}

}  // namespace

bool is_zarr_metadata(std::string_view name) { return std::find(kMetadata.begin(), kMetadata.end(), name) != kMetadata.end(); }

bool is_hidden(std::string_view name) { return name.starts_with('.') && !is_zarr_metadata(name); }

bool is_zarr(const fs::path& folder) {
  std::error_code error;
  if (small_letters(plain_folder(folder).extension().string()) == ".zarr" || fs::is_regular_file(folder / ".zarray", error)) return true;
  if (file_beginning(folder / ".zattrs").find("\"multiscales\"") != std::string::npos) return true;
  if (names_axes_of_arrays(folder)) return true;
  const std::string text = file_beginning(folder / "zarr.json");
  return text.find("\"multiscales\"") != std::string::npos || (text.find("\"array\"") != std::string::npos && text.find("\"group\"") == std::string::npos);
}

std::vector<fs::path> zarr_files_above(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_regular_file(folder / ".zarray", error) && !fs::is_regular_file(folder / "zarr.json", error)) return {};
  const fs::path above = plain_folder(folder).parent_path();
  return {above / ".zattrs", above / "zarr.json"};
}

int deepest_file(const fs::path& folder) {
  std::error_code error;
  return is_zarr(folder) ? 16 : fs::is_regular_file(folder / "system" / "controlDict", error) ? 4 : 2;
}

}  // namespace isostrata
