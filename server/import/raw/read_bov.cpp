#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "import/images/read_nrrd.h"
#include "import/imported/read_own.h"
#include "import/raw/header_lines.h"
#include "import/raw/raw_axes.h"

namespace isostrata {
namespace {

ScalarType type_of(const HeaderLines& lines) {
  const std::string word = lines.word("data_format");
  for (const auto& [names, type] : {std::pair{" byte bytes ", ScalarType::uint8}, {" short shorts ", ScalarType::int16}, {" int ints integer integers ", ScalarType::int32},
                                    {" float floats real ", ScalarType::float32}, {" double doubles ", ScalarType::float64}})
    if (!word.empty() && std::string(names).find(" " + word + " ") != std::string::npos) return type;
  throw Error(ErrorCode::bad_data, lines.name() + ": DATA_FORMAT is '" + word.substr(0, 32) + "'; expected BYTE, SHORT, INT, FLOAT or DOUBLE");
}

/// Cells in place of points: one point more along each axis.
void make_cells(Block& block, const std::array<double, 3>& size) {
  auto& grid = std::get<UniformGrid>(block.grid.shape);
  for (int a = 0; a < 3; ++a) {
    const auto n = grid.dims[static_cast<std::size_t>(a)];
    if (n == 1 && a == 2) continue;  // a plane
    grid.spacing[a] = size[static_cast<std::size_t>(a)] / static_cast<double>(n);
    grid.dims[static_cast<std::size_t>(a)] = n + 1;
  }
  for (FileArray& array : block.arrays) array.on_cells = true;
}

}  // namespace

// VisIt's Brick Of Values: "The BOV file format" of its manual.
Imported read_bov(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const auto file = std::make_shared<const MappedFile>(request.file);
  const std::string_view text(reinterpret_cast<const char*>(file->bytes().data()), std::min<std::size_t>(file->bytes().size(), 1 << 16));
  const HeaderLines lines(text, name);
  const std::string& data = lines.needed("data_file");
  if (data.find('%') != std::string::npos)
    throw Error(ErrorCode::unsupported, name + ": its values are in several files ('" + data.substr(0, 64) + "'); expected one DATA_FILE");
  NrrdHeader header;
  header.type = type_of(lines);
  header.data_files = {data};
  if (data.ends_with(".gz")) header.encoding = NrrdEncoding::gzip;
  header.big_endian = lines.word("data_endian", "little") == "big";
  if (lines.find("byte_offset")) header.byte_skip = lines.numbers<std::int64_t>("byte_offset", 1)[0];
  if (header.byte_skip < 0) throw Error(ErrorCode::bad_data, name + ": BYTE_OFFSET is " + std::to_string(header.byte_skip) + "; expected at least 0");
  const std::int64_t components = lines.word("data_components") == "complex" ? 2 : lines.find("data_components") ? lines.numbers<std::int64_t>("data_components", 1)[0] : 1;
  if (components != 1) add_axis(header, components, NrrdRole::component, name);
  const auto sizes = lines.numbers<std::int64_t>("data_size", 3);
  const bool cells = lines.word("centering", "nodal") == "zonal";
  const std::vector<double> origin = lines.find("brick_origin") ? lines.numbers<double>("brick_origin", 3) : std::vector<double>{0, 0, 0};
  std::array<double, 3> whole{};
  for (std::size_t a = 0; a < 3; ++a) {
    NrrdAxis& axis = add_axis(header, sizes[a], NrrdRole::space, name);
    const auto between = static_cast<double>(std::max<std::int64_t>(cells ? sizes[a] : sizes[a] - 1, 1));
    whole[a] = lines.find("brick_size") ? lines.numbers<double>("brick_size", 3)[a] : between;
    axis.spacing = sizes[a] == 1 && whole[a] == 0 ? 1 : whole[a] / between;
  }
  header.origin = {origin[0], origin[1], origin[2]};
  const std::string* variable = lines.find("variable");
  Imported imported = read_described(request, header, file, variable && !variable->empty() ? *variable : "scalars");
  if (cells) make_cells(imported.blocks.front(), whole);
  if (const std::string* time = lines.find("time"); time && !time->empty()) imported.times = {lines.numbers<double>("time", 1)[0]};
  if (!std::isfinite(imported.times[0])) throw Error(ErrorCode::bad_data, name + ": TIME is not a finite number");
  return imported;
}

}  // namespace isostrata
