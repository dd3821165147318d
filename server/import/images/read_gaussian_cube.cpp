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
#include "import/bytes/parsed_number.h"
#include "import/bytes/text_numbers.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

/// How many values each point has; 1 if the line says nothing that can be a count of them.
std::int64_t trailing_count(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
  const auto count = parsed_number<std::int64_t>(line.substr(0, line.find_first_of(" \t\r")));
  return count && *count >= 1 && *count <= 1000 ? *count : 1;
}

/// What the two lines of text say that the only field is; a density where they say nothing.
std::string name_by(std::string_view remarks) {
  std::string text;
  for (const char c : remarks) text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto says = [&](std::string_view word) { return text.find(word) != std::string::npos; };
  for (const std::string_view orbital : {"wavefunction", "orbital", " mo "})
    if (const auto at = text.find(orbital); at != std::string::npos) {
      std::string_view rest = std::string_view(text).substr(at + orbital.size());
      rest.remove_prefix(std::min(rest.find_first_not_of(" \t:#="), rest.size()));
      const auto number = parsed_number<std::int64_t>(rest.substr(0, std::min(rest.find_first_not_of("0123456789"), rest.size())));
      return number ? "orbital " + std::to_string(*number) : "orbital";
    }
  if (says("potential")) return "potential";
  if (says(" elf") || says("localization")) return "localization";
  if (says("spin density") || says("spin-density") || says("spin_density")) return "spin density";
  return "density";
}

}  // namespace

// Gaussian's cube files: two lines of text; atoms, origin and the number of values in each point, if it is not 1; three lines of count and step; the atoms; then the values, z fastest. A negative
// number of atoms says that a line with the number of fields and their names follows; a negative count that lengths are in Angstrom.
Imported read_gaussian_cube(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  const MappedFile file(request.file);
  TextNumbers words({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()}, name);
  std::string remarks(words.rest_of_line());
  remarks = " " + remarks + " ";
  remarks += words.rest_of_line();
  std::int64_t atoms = words.integer("the number of atoms", 1'000'000);
  const bool named_fields = atoms < 0;
  atoms = std::abs(atoms);
  std::array<double, 3> origin{};
  for (double& x : origin) x = words.number("the origin");
  const std::int64_t values_of_point = trailing_count(words.rest_of_line());
  std::array<std::int64_t, 3> dims{};
  std::array<std::array<double, 3>, 3> step{};
  std::string unit;
  std::int64_t fields = named_fields ? 1 : values_of_point;
  for (std::size_t a = 0; a < 3; ++a) {
    dims[a] = words.integer("the number of points along an axis", 1 << 24);
    if (a == 0) unit = dims[a] < 0 ? "Angstrom" : "Bohr";
    dims[a] = std::abs(dims[a]);
    if (dims[a] == 0) throw Error(ErrorCode::bad_data, name + ": no points along an axis");
    for (double& x : step[a]) x = words.number("the step along an axis");
    words.skip_line();
  }
  for (std::int64_t i = 0; i < atoms; ++i) words.skip_line();
  std::vector<std::string> names{name_by(remarks)};
  if (fields > 1) names.clear();
  for (std::int64_t i = 1; fields > 1 && i <= fields; ++i) names.push_back("value " + std::to_string(i));
  if (named_fields) {
    fields = words.integer("the number of fields", 1000);
    if (fields < 1) throw Error(ErrorCode::bad_data, name + ": has no field");
    names.clear();
    for (std::int64_t i = 0; i < fields; ++i) names.push_back("orbital " + std::to_string(words.integer("the number of an orbital", 1 << 30)));
  }
  const std::int64_t points = checked_product({dims[0], dims[1], dims[2]}, name);
  const std::int64_t values = checked_product({points, fields}, name);
  if (values > static_cast<std::int64_t>(file.bytes().size()))
    throw Error(ErrorCode::bad_data, name + ": " + std::to_string(values) + " values declared in a file of " + std::to_string(file.bytes().size()) + " bytes");
  check_bytes(request, static_cast<std::uint64_t>(values) * sizeof(double), name);

  Imported imported;
  imported.axes = axes_in(unit);
  Block block;
  place_image(block, dims, origin, step, name);
  std::vector<std::span<double>> to;
  for (const std::string& field : names) {
    auto [storage, span] = allocate<double>(static_cast<std::size_t>(points));
    to.push_back(span);
    FileArray array;
    array.name = field;
    array.type = ScalarType::float64;
    array.values = std::as_bytes(span);
    array.storage = storage;
    block.arrays.push_back(std::move(array));
  }
  for (std::int64_t i = 0; i < dims[0]; ++i) {
    request.progress(static_cast<double>(i) / static_cast<double>(dims[0]));
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t k = 0; k < dims[2]; ++k)
        for (std::span<double>& field : to) field[static_cast<std::size_t>(i + dims[0] * (j + dims[1] * k))] = words.number("a value");
  }
  imported.blocks.push_back(std::move(block));
  return imported;
}

}  // namespace isostrata
