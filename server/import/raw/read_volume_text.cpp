#include <algorithm>
#include <array>
#include <utility>

#include "data/files/raw_name.h"
#include "import/images/read_nrrd.h"
#include "import/imported/read_own.h"
#include "import/raw/header_lines.h"
#include "import/raw/raw_axes.h"

namespace isostrata {
namespace {

/// "UCHAR", "USHORT_12", "FLOAT32", "Vec3FLOAT32": the type, and how many of it a point has.
std::pair<ScalarType, std::int64_t> format_of(const HeaderLines& lines) {
  std::string word = small_letters(lines.needed("format"));
  std::int64_t components = 1;
  if (word.size() > 4 && word.starts_with("vec") && word[3] >= '2' && word[3] <= '4') {
    components = word[3] - '0';
    word = word.substr(4);
  }
  const auto type = word == "ushort_12" ? std::optional(ScalarType::uint16) : scalar_type_named(word);
  if (!type) throw Error(ErrorCode::unsupported, lines.name() + ": Format is '" + lines.needed("format").substr(0, 32) + "'; expected UCHAR, USHORT, FLOAT32 or the like");
  return {*type, components};
}

/// Of Inviwo: three vectors along the whole volume, whose corner the offset is; points are the middles of its boxes.
void place(NrrdHeader& header, const HeaderLines& lines, std::size_t first_axis) {
  const bool at = lines.find("offset");
  std::array<double, 3> origin{};
  if (at) {
    const auto offset = lines.numbers<double>("offset", 3);
    std::copy_n(offset.begin(), 3, origin.begin());
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const auto whole = lines.numbers<double>("basisvector" + std::to_string(a + 1), 3);
    NrrdAxis& axis = header.axes[first_axis + a];
    std::array<double, 3> step{};
    for (std::size_t c = 0; c < 3; ++c) {
      step[c] = whole[c] / static_cast<double>(axis.size);
      origin[c] += step[c] / 2;
      if (!at) origin[c] -= whole[c] / 2;  // about the middle of the world
    }
    axis.direction = step;
  }
  header.origin = origin;
}

}  // namespace

// The text beside a .raw file of volvis.org's volumes (ObjectFileName) and of Inviwo (RawFile).
Imported read_volume_text(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const auto file = std::make_shared<const MappedFile>(request.file);
  const HeaderLines lines({reinterpret_cast<const char*>(file->bytes().data()), std::min<std::size_t>(file->bytes().size(), 1 << 16)}, name);
  const std::string data = lines.find("rawfile") ? lines.needed("rawfile") : lines.needed("objectfilename");
  if (data.find('%') != std::string::npos) throw Error(ErrorCode::unsupported, name + ": its values are in several files ('" + data.substr(0, 64) + "'); expected one");
  NrrdHeader header;
  header.data_files = {data};
  const auto [type, components] = format_of(lines);
  header.type = type;
  header.big_endian = lines.word("byteorder").starts_with("big") || lines.word("endian").starts_with("big");
  if (lines.find("byteoffset")) header.byte_skip = std::max<std::int64_t>(lines.numbers<std::int64_t>("byteoffset", 1)[0], 0);
  if (const std::string* unit = lines.find("valueunit")) header.unit = *unit;
  if (components > 1) add_axis(header, components, NrrdRole::component, name);
  const std::size_t first = header.axes.size();
  const auto sizes = lines.numbers<std::int64_t>("resolution", 3);
  const std::string distance = lines.find("slicethickness") ? "slicethickness" : lines.find("spacing") ? "spacing" : "";
  for (std::size_t a = 0; a < 3; ++a) {
    NrrdAxis& axis = add_axis(header, sizes[a], NrrdRole::space, name);
    if (!distance.empty()) axis.spacing = lines.numbers<double>(distance, 3)[a];
  }
  if (lines.find("basisvector1")) place(header, lines, first);
  return read_described(request, header, file, "scalars");
}

}  // namespace isostrata
