#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "data/files/raw_name.h"
#include "import/images/read_nrrd.h"
#include "import/imported/read_own.h"
#include "import/raw/header_lines.h"
#include "import/raw/raw_axes.h"

namespace isostrata {
namespace {

/// "Float32LE", "UInt8": nothing of single bits and complex numbers.
std::optional<ScalarType> type_of(std::string word) {
  if (word.ends_with("le") || word.ends_with("be")) word.resize(word.size() - 2);
  return scalar_type_named(word);
}

/// "-0,-1,+2,+3": of each axis its place among them, the fastest first, and whether it runs backwards.
struct Layout {
  std::vector<std::size_t> axes;  // the fastest first
  std::vector<bool> backwards;    // by axis
};
Layout layout_of(const HeaderLines& lines, std::size_t count) {
  Layout layout{std::vector<std::size_t>(count, count), std::vector<bool>(count)};
  std::string_view rest = lines.needed("layout");
  for (std::size_t a = 0; a < count; ++a) {
    const std::string_view one = trimmed(rest.substr(0, rest.find(',')));
    rest.remove_prefix(std::min(rest.find(','), rest.size() - 1) + 1);
    const auto place = parsed_number<std::size_t>(one.starts_with('+') || one.starts_with('-') ? one.substr(1) : one);
    if (!place || *place >= count || layout.axes[*place] != count)
      throw Error(ErrorCode::bad_data, lines.name() + ": layout is '" + lines.needed("layout").substr(0, 64) + "'; expected each of " + std::to_string(count) + " places once");
    layout.axes[*place] = a;
    layout.backwards[a] = one.starts_with('-');
    if (rest.empty() && a + 1 < count) throw Error(ErrorCode::bad_data, lines.name() + ": layout has fewer places than dim has axes");
  }
  return layout;
}

/// The rows of "transform", which stands once for each.
std::vector<std::array<double, 4>> transform_of(std::string_view text, const std::string& name) {
  std::vector<std::array<double, 4>> rows;
  for (auto at = text.find("\ntransform:"); at != std::string_view::npos && rows.size() < 3; at = text.find("\ntransform:", at + 1)) {
    const HeaderLines one(text.substr(at + 1, text.find('\n', at + 1) - at - 1), name);
    const auto numbers = one.numbers<double>("transform", 4);
    rows.push_back({numbers[0], numbers[1], numbers[2], numbers[3]});
  }
  if (rows.empty()) return {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  if (rows.size() < 3) throw Error(ErrorCode::bad_data, name + ": transform has " + std::to_string(rows.size()) + " rows; expected 3");
  return rows;
}

/// Places in the scanner's space: the transform of the axes as they are counted, whichever way they are stored.
void place(NrrdHeader& header, const Layout& layout, const std::vector<std::int64_t>& sizes, const std::vector<double>& vox, const std::vector<std::array<double, 4>>& rows) {
  std::array<double, 3> origin{rows[0][3], rows[1][3], rows[2][3]};
  std::size_t at = 0;
  for (const std::size_t a : layout.axes) {
    NrrdAxis& axis = header.axes[at++];
    if (a >= 3) continue;
    std::array<double, 3> step{};
    for (std::size_t c = 0; c < 3; ++c) {
      step[c] = rows[c][a] * vox[a];
      if (!layout.backwards[a]) continue;
      origin[c] += step[c] * static_cast<double>(sizes[a] - 1);
      step[c] = step[c] == 0 ? 0 : -step[c];
    }
    axis.direction = step;
  }
  header.origin = origin;
  header.space_units.fill("mm");
}

/// offset + scale * value, as floats.
void scale(FileArray& array, double offset, double factor) {
  const std::size_t count = array.values.size() / size_of(array.type);
  auto [storage, to] = allocate<float>(count);
  std::visit([&, to = to](auto from) { for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<float>(offset + factor * static_cast<double>(from[i])); },
             scalar_span(array.type, array.values));
  array.type = ScalarType::float32;
  array.values = std::as_bytes(std::span<const float>(to));
  array.storage = storage;
}

}  // namespace

// "MRtrix image formats" of its documentation.
Imported read_mrtrix(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const auto file = std::make_shared<const MappedFile>(request.file);
  std::string_view text(reinterpret_cast<const char*>(file->bytes().data()), std::min<std::size_t>(file->bytes().size(), 16 << 20));
  const auto end = text.find("\nEND");
  if (end == std::string_view::npos) throw Error(ErrorCode::bad_data, name + ": its header has no END");
  text = text.substr(0, end + 1);
  const HeaderLines lines(text, name);
  NrrdHeader header;
  const std::string word = lines.word("datatype");
  const auto type = type_of(word);
  if (!type) throw Error(ErrorCode::unsupported, name + ": datatype is '" + word.substr(0, 32) + "'; expected whole or real numbers of 8 to 64 bits");
  header.type = *type;
  header.big_endian = word.ends_with("be");
  const auto sizes = lines.numbers<std::int64_t>("dim", 3);
  if (sizes.size() > 4) throw Error(ErrorCode::unsupported, name + ": " + std::to_string(sizes.size()) + " axes; expected three, or a fourth of volumes");
  const Layout layout = layout_of(lines, sizes.size());
  for (const std::size_t a : layout.axes) add_axis(header, sizes[a], a == 3 ? NrrdRole::time : NrrdRole::space, name);
  place(header, layout, sizes, lines.numbers<double>("vox", 3), transform_of(text, name));
  const std::string& where = lines.needed("file");
  const auto blank = where.find(' ');
  const auto skip = parsed_number<std::int64_t>(blank == std::string::npos ? std::string_view("0") : trimmed(std::string_view(where).substr(blank)));
  if (!skip || *skip < 0) throw Error(ErrorCode::bad_data, name + ": file is '" + where.substr(0, 64) + "'; expected a name and where the values begin");
  header.byte_skip = *skip;
  if (where.substr(0, blank) != ".") header.data_files = {where.substr(0, blank)};
  Imported imported = read_described(request, header, file, "scalars");
  if (lines.find("scaling")) {
    const auto by = lines.numbers<double>("scaling", 2);
    if (by[0] != 0 || by[1] != 1) scale(imported.blocks.front().arrays.front(), by[0], by[1]);
  }
  if (sizes.size() == 4) imported.notes.push_back("the volumes of its fourth axis are steps");
  return imported;
}

}  // namespace isostrata
