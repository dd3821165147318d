#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "import/bytes/mapped_file.h"
#include "import/bytes/text_numbers.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

constexpr std::int64_t kMostAlongAxis = 1 << 24;

struct Lattice {
  std::array<std::int64_t, 3> dims{};
  std::array<double, 3> origin{};
  std::array<std::array<double, 3>, 3> edges{};
  bool operator==(const Lattice&) const = default;
};

std::string_view text_of(const MappedFile& file) { return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()}; }

std::array<std::int64_t, 3> read_dims(TextNumbers& words, std::int64_t least) {
  std::array<std::int64_t, 3> dims{};
  for (std::int64_t& n : dims) {
    n = words.integer("the number of points along an axis", kMostAlongAxis);
    if (n < least) throw Error(ErrorCode::bad_data, words.name() + ": " + std::to_string(n) + " points along an axis; expected at least " + std::to_string(least));
  }
  return dims;
}

/// Room for a value at each point, if so many can be in what is left of the text.
FileArray new_array(const std::array<std::int64_t, 3>& dims, std::int64_t in_file, const std::string& array, const TextNumbers& words, const ReadRequest& request, std::uint64_t& bytes) {
  if (static_cast<std::uint64_t>(in_file) > words.left())
    throw Error(ErrorCode::bad_data, words.name() + ": " + std::to_string(in_file) + " values declared, and " + std::to_string(words.left()) + " bytes left for them");
  const auto points = static_cast<std::size_t>(checked_product({dims[0], dims[1], dims[2]}, words.name()));
  check_bytes(request, bytes += points * sizeof(double), words.name());
  FileArray out;
  out.name = array;
  out.type = ScalarType::float64;
  auto [storage, values] = allocate<double>(points);
  out.values = std::as_bytes(values);
  out.storage = storage;
  return out;
}

std::span<double> values_of(const FileArray& array) { return {reinterpret_cast<double*>(const_cast<std::byte*>(array.values.data())), array.values.size() / sizeof(double)}; }

std::string free_name(std::string name, const std::vector<FileArray>& arrays) {
  const auto taken = [&](const std::string& one) { return std::any_of(arrays.begin(), arrays.end(), [&](const FileArray& array) { return array.name == one; }); };
  if (!taken(name)) return name;
  int n = 2;
  while (taken(name + " " + std::to_string(n))) ++n;
  return name + " " + std::to_string(n);
}

double determinant(const std::array<std::array<double, 3>, 3>& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// The values of VASP have no point for the far sides of the cell, which are the near ones again.
void read_periodic(TextNumbers& words, const std::array<std::int64_t, 3>& in_file, double divisor, std::span<double> to, const ReadRequest& request) {
  const auto [nx, ny, nz] = in_file;
  const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) -> double& { return to[static_cast<std::size_t>(i + (nx + 1) * (j + (ny + 1) * k))]; };
  for (std::int64_t k = 0; k < nz; ++k) {
    request.progress(static_cast<double>(k) / static_cast<double>(nz));
    for (std::int64_t j = 0; j < ny; ++j)
      for (std::int64_t i = 0; i < nx; ++i) at(i, j, k) = words.number("a value") / divisor;
  }
  for (std::int64_t k = 0; k <= nz; ++k)
    for (std::int64_t j = 0; j <= ny; ++j)
      for (std::int64_t i = 0; i <= nx; ++i) at(i, j, k) = at(i % nx, j % ny, k % nz);
}

/// What its name says that VASP has written: the names of its grids, and whether these are by the cell's volume.
struct VaspNames {
  std::vector<std::string> arrays;
  bool by_volume = true;
  const char* unit = "";
};
VaspNames vasp_names(std::string file) {
  std::transform(file.begin(), file.end(), file.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (file.starts_with("locpot")) return {{"potential", "potential of the second spin"}, false, "eV"};
  if (file.starts_with("elfcar")) return {{"localization", "localization of the second spin"}, false, ""};
  return {{"charge density", "magnetization density"}, true, "e/Å³"};
}

}  // namespace

// XCrySDen: among keywords BEGIN_DATAGRID_3D_name or DATAGRID_3D_name; the numbers of points; the origin; three edges; the values, x fastest; END_DATAGRID_3D. The last points of an axis are at the
// edge's end.
Imported read_xsf(const ReadRequest& request) {
  check_step(request, 1);
  const std::string name = request.file.filename().string();
  const MappedFile file(request.file);
  TextNumbers words(text_of(file), name);
  Lattice first;
  Block block;
  std::uint64_t bytes = 0;
  int others = 0;
  constexpr std::string_view kGrid = "DATAGRID_3D";
  while (words.left() > 0) {
    const std::string_view line = words.next_line();
    const auto at = line.find(kGrid);
    if (at == std::string_view::npos || line.starts_with("END_") || line.find("BLOCK") != std::string_view::npos || line.starts_with('#')) continue;
    std::string called(line.substr(at + kGrid.size()));
    called = called.starts_with('_') ? called.substr(1) : called;
    Lattice own;
    own.dims = read_dims(words, 2);
    for (double& x : own.origin) x = words.number("the origin");
    for (auto& edge : own.edges)
      for (double& x : edge) x = words.number("an edge");
    const std::int64_t points = checked_product({own.dims[0], own.dims[1], own.dims[2]}, name);
    if (!block.arrays.empty() && own != first) {
      ++others;
      for (std::int64_t i = 0; i < points; ++i) static_cast<void>(words.number("a value"));
      continue;
    }
    first = own;
    const FileArray array = new_array(own.dims, points, free_name(called.empty() ? "values" : called, block.arrays), words, request, bytes);
    for (double& value : values_of(array)) value = words.number("a value");
    block.arrays.push_back(array);
  }
  if (block.arrays.empty()) throw Error(ErrorCode::bad_data, name + ": has no grid of three axes; expected BEGIN_DATAGRID_3D");
  auto step = first.edges;
  for (std::size_t a = 0; a < 3; ++a)
    for (double& x : step[a]) x /= static_cast<double>(first.dims[a] - 1);
  place_image(block, first.dims, first.origin, step, name);
  Imported imported;
  imported.axes = axes_in("Angstrom");
  if (others > 0) imported.notes.push_back(std::to_string(others) + " grids of other points than the first one's skipped");
  imported.blocks.push_back(std::move(block));
  return imported;
}

// VASP: a title; a scale, or less its third power the volume, or one for each axis; the cell's edges; the elements' names, which old files lack; the number of atoms of each; "Selective dynamics"
// perhaps; "Direct" or "Cartesian"; the atoms; then the numbers of points and the values, x fastest. Densities are followed by occupancies, and by the grid of the spins with the same numbers before it.
Imported read_vasp(const ReadRequest& request) {
  check_step(request, 1);
  const std::string name = request.file.filename().string();
  const MappedFile file(request.file);
  TextNumbers words(text_of(file), name);
  words.skip_line();
  std::vector<double> scale;
  for (TextNumbers of(words.next_line(), name); of.number_follows() && scale.size() < 3;) scale.push_back(of.number("the scale of the cell"));
  if (scale.empty()) throw Error(ErrorCode::bad_data, name + ": expected the scale of the cell in the line behind the title");
  std::array<std::array<double, 3>, 3> edges{};
  for (auto& edge : edges)
    for (double& x : edge) x = words.number("an edge of the cell");
  if (scale.size() == 1 && scale[0] < 0) scale[0] = std::cbrt(-scale[0] / std::abs(determinant(edges)));
  for (auto& edge : edges)
    for (std::size_t a = 0; a < 3; ++a) edge[a] *= scale.size() == 3 ? scale[a] : scale[0];
  std::string_view counts = words.next_line();
  if (counts.find_first_of("0123456789") != 0) counts = words.next_line();  // those were names
  std::int64_t atoms = 0;
  for (TextNumbers of(counts, name); of.number_follows();) atoms += of.integer("the number of atoms of an element", 100'000'000);
  if (const std::string_view line = words.next_line(); line.starts_with('S') || line.starts_with('s')) static_cast<void>(words.next_line());
  for (std::int64_t i = 0; i < atoms && words.left() > 0; ++i) static_cast<void>(words.next_line());
  if (words.left() == 0) throw Error(ErrorCode::bad_data, name + ": ends behind its " + std::to_string(atoms) + " atoms; expected a grid of values, as CHGCAR and LOCPOT have");

  const std::array<std::int64_t, 3> in_file = read_dims(words, 1);
  const std::array<std::int64_t, 3> dims{in_file[0] + 1, in_file[1] + 1, in_file[2] + 1};
  const std::int64_t points = checked_product({in_file[0], in_file[1], in_file[2]}, name);
  const VaspNames names = vasp_names(name);
  const double divisor = names.by_volume ? std::abs(determinant(edges)) : 1;
  if (!(divisor > 0)) throw Error(ErrorCode::bad_data, name + ": its cell has no volume");
  Block block;
  std::uint64_t bytes = 0;
  const std::string size = std::to_string(in_file[0]) + " " + std::to_string(in_file[1]) + " " + std::to_string(in_file[2]);
  const auto read = [&] {
    const std::string called = names.arrays[std::min(block.arrays.size(), names.arrays.size() - 1)];
    FileArray array = new_array(dims, points, free_name(called, block.arrays), words, request, bytes);
    array.unit = names.unit;
    read_periodic(words, in_file, divisor, values_of(array), request);
    block.arrays.push_back(array);
  };
  read();
  while (words.left() > 0 && block.arrays.size() < 4) {
    const std::string_view line = words.next_line();
    std::string plain;
    for (const char c : line)
      if (c != ' ' || (!plain.empty() && plain.back() != ' ')) plain += c;
    if (plain == size) read();
  }
  auto step = edges;
  for (std::size_t a = 0; a < 3; ++a)
    for (double& x : step[a]) x /= static_cast<double>(in_file[a]);
  place_image(block, dims, {0, 0, 0}, step, name);
  Imported imported;
  imported.axes = axes_in("Angstrom");
  imported.blocks.push_back(std::move(block));
  return imported;
}

}  // namespace isostrata
