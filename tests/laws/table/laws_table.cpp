// isostrata-laws: the laws of interval volumes over every file of the shared test data and every array in it, as a table. Exits
// with 1 if one breaks.
//
//   cmake --build --preset release --target isostrata-laws && build/release/bin/isostrata-laws [--parts K] [FILE...]
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "base/error.h"
#include "laws/partition_law.h"
#include "support/shared_data.h"

namespace isostrata::laws {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMostCells = 600'000;  // active in one run
constexpr std::size_t kMostArrays = 24;       // of one file
constexpr double kRounding = 1e-10;           // relative, of sums over up to some million tetrahedra

std::vector<fs::path> data_files(const fs::path& folder) {
  static const std::set<std::string> kExtensions{".vtk",  ".vti",  ".vtr", ".vts", ".vtu", ".pvd", ".pvtu", ".pvti", ".pvtr",
                                                 ".nrrd", ".nhdr", ".mhd", ".slc", ".e",   ".ex2", ".xyz",  ".bin",  ".q"};
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && kExtensions.contains(entry.path().extension().string())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Cells that overlap meet more facets than their neighbours': here a quadratic tetrahedron whose corners lie flat in the face of
/// a hexahedron.
const std::set<std::string> kOverlapping{"fmt_vtk_variants/unstructured_grid_complex.vtk"};

struct Totals {
  int files = 0, refused = 0, without_cells = 0, arrays = 0, broken = 0;
  double worst_error = 0, worst_unexplained = 0;
  std::string worst_error_at, worst_unexplained_at;
};

void check_array(const Dataset& data, const PointArray& array, const std::string& name, int parts, Totals& totals) {
  const Partition law = partition_law(data, array, parts, kMostCells);
  const std::string at = name + " " + array.name;
  const bool overlapping = kOverlapping.contains(name);
  const bool matched = law.whole.unmatched == 0 && law.cut.unmatched == 0;
  const bool holds = (matched || overlapping) && law.unexplained() <= kRounding;
  std::printf("%-58.58s %9lld %2d %10lld %9lld %9lld %4lld %9.2e %9.2e%s\n", at.c_str(), static_cast<long long>(law.active_cells),
              law.parts, static_cast<long long>(law.cut.tetrahedra), static_cast<long long>(law.whole.inverted),
              static_cast<long long>(law.cut.inverted), static_cast<long long>(law.whole.unmatched + law.cut.unmatched),
              law.error(), law.unexplained(),
              !holds    ? "  BROKEN"
              : matched ? ""
                        : "  cells overlap");
  std::fflush(stdout);
  ++totals.arrays;
  totals.broken += !holds;
  if (law.error() > totals.worst_error) totals.worst_error = law.error(), totals.worst_error_at = at;
  if (law.unexplained() > totals.worst_unexplained)
    totals.worst_unexplained = law.unexplained(), totals.worst_unexplained_at = at;
}

void check_file(const fs::path& file, const fs::path& folder, int parts, Totals& totals) {
  const std::string name = fs::relative(file, folder).string();
  ++totals.files;
  std::shared_ptr<const Dataset> data;
  try {
    data = open_dataset(file.string(), {}, Task());
  } catch (const Error&) {
    ++totals.refused;  // what must be refused is tested in tests/data
    return;
  }
  if (data->grid.cell_count() == 0) {
    ++totals.without_cells;
    return;
  }
  std::size_t checked = 0;
  for (const PointArray& array : data->arrays) {
    if (array.lower > array.upper || checked++ == kMostArrays) continue;
    check_array(*data, array, name, parts, totals);
  }
}

int run(int argc, char** argv) {
  int parts = 7;
  std::vector<fs::path> files;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--parts" && i + 1 < argc)
      parts = std::max(1, std::atoi(argv[++i]));
    else
      files.emplace_back(argv[i]);
  }
  const fs::path folder = testing::shared_data();
  if (files.empty()) {
    if (!fs::is_directory(folder)) {
      std::printf("no test data at %s: set ISOSTRATA_TEST_DATA\n", folder.c_str());
      return 2;
    }
    files = data_files(folder);
  }
  std::printf("%-58s %9s %2s %10s %9s %9s %4s %9s %9s\n", "file and array", "active", "k", "tetrahedra", "inverted1", "inverted",
              "open", "error", "unexpl.");
  Totals totals;
  for (const fs::path& file : files) check_file(file, folder, parts, totals);
  std::printf(
      "%d files (%d refused, %d without 3-D cells), %d arrays, %d broken\nworst partition error %.2e (%s)\nworst unexplained "
      "%.2e (%s)\n",
      totals.files, totals.refused, totals.without_cells, totals.arrays, totals.broken, totals.worst_error,
      totals.worst_error_at.c_str(), totals.worst_unexplained, totals.worst_unexplained_at.c_str());
  return totals.broken ? 1 : 0;
}

}  // namespace
}  // namespace isostrata::laws

int main(int argc, char** argv) { return isostrata::laws::run(argc, argv); }
