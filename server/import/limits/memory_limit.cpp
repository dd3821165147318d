#include "import/limits/memory_limit.h"

#include <sys/sysinfo.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>

#include "base/error.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kLibraries = std::uint64_t{512} << 20;  // address space: 200 MiB with VTK 9.1, of which a tenth is touched
constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

/// What Linux could give without swapping.
std::uint64_t free_bytes() {
  std::ifstream facts("/proc/meminfo");
  for (std::string name, unit; facts >> name;) {
    std::uint64_t kib = 0;
    if (name == "MemAvailable:" && facts >> kib) return kib << 10;
    std::getline(facts, unit);
  }
  struct sysinfo info {};
  return sysinfo(&info) == 0 ? static_cast<std::uint64_t>(info.totalram) * info.mem_unit : kMost / 4;
}

/// Formats whose every byte is in the file itself.
bool stands_alone(const fs::path& file) {
  static constexpr std::array kEndings = {".vtk", ".vti", ".vtr", ".vts", ".vtu", ".slc", ".e", ".ex2", ".exo", ".exii", ".g"};
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

/// kMost if it is too many files to look at.
std::uint64_t stored_bytes(const fs::path& file) {
  std::error_code error;
  const std::uint64_t own = fs::file_size(file, error);
  if (error) return kMost;
  if (stands_alone(file)) return own;
  constexpr int kMostFiles = 20000;
  std::uint64_t sum = own;
  int seen = 0;
  fs::recursive_directory_iterator it(file.parent_path(), fs::directory_options::skip_permission_denied, error), end;
  for (; !error && it != end; it.increment(error)) {
    if (++seen > kMostFiles) return kMost;
    std::error_code ignored;
    if (!it->is_regular_file(ignored)) continue;
    const std::uint64_t bytes = it->file_size(ignored);
    if (!ignored) sum += bytes;
  }
  return error ? kMost : sum;
}

/// What `stored` bytes can hold.
std::uint64_t most_unpacked(std::uint64_t stored) {
  constexpr std::uint64_t kRatio = 1032;  // of deflate, at best
  return stored > kMost / kRatio ? kMost : kRatio * stored;
}

}  // namespace

void check_unpacked(std::uint64_t declared, std::uint64_t stored, const std::string& name) {
  const std::uint64_t most = most_unpacked(stored);
  if (declared > most)
    throw Error(ErrorCode::bad_data, name + ": " + std::to_string(declared) + " bytes declared; " + std::to_string(stored) + " are there, which hold at most " +
                                         std::to_string(most));
}

std::uint64_t unpacked_bytes(std::uint64_t stored) {
  constexpr std::uint64_t kSmall = std::uint64_t{512} << 20;  // what a small file of any format may take
  const std::uint64_t once = most_unpacked(stored);
  return once > (kMost - kSmall) / 3 ? kMost : kSmall + 3 * once;
}

std::uint64_t memory_limit(const fs::path& file, std::uint64_t max_bytes) {
  const std::uint64_t wanted = 3 * std::min(max_bytes, kMost / 8);
  return std::min({wanted, unpacked_bytes(stored_bytes(file)), free_bytes()}) + kLibraries;
}

std::uint64_t cpu_limit(const fs::path& file, std::uint64_t most) {
  constexpr std::uint64_t kStart = 8;                          // libraries, on a slow machine
  constexpr std::uint64_t kSlowest = std::uint64_t{256} << 10;  // bytes a second: a tenth of what VTK reads of packed XML
  return std::min(most, kStart + stored_bytes(file) / kSlowest);
}

}  // namespace isostrata
