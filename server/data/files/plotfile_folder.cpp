#include "data/files/plotfile_folder.h"

#include <string>
#include <system_error>

#include "data/files/file_beginning.h"

namespace isostrata {

bool is_plotfile(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(folder / "Header", error) || !std::filesystem::is_directory(folder / "Level_0", error)) return false;
  const std::string head = file_beginning(folder / "Header", 256);
  const std::size_t first = head.find('\n'), version = head.find("-V");
  if (first == std::string::npos || version == std::string::npos || version > first) return false;
  const std::string components = head.substr(first + 1, head.find('\n', first + 1) - first - 1);
  const std::size_t last = components.find_last_not_of(" \t\r");
  return last != std::string::npos && components.substr(0, last + 1).find_first_not_of("0123456789") == std::string::npos;
}

}  // namespace isostrata
