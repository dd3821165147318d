// FITS: the first image of a file. Axes of Stokes parameters are arrays, one of time steps, up to three others space.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>
#include <type_traits>

#include "import/bytes/swap_bytes.h"
#include "import/images/fits_header.h"
#include "import/images/fits_tiles.h"
#include "import/imported/appended_file.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

/// One axis of more than one point, or none (of one).
struct FitsAxis {
  int number = 0;  // from 1, as keywords have it
  std::int64_t size = 1, step = 0;  // values from one of its points to the next
};

struct FitsAxes {
  std::array<FitsAxis, 3> space;
  std::size_t count = 0;  // of those
  FitsAxis time, stokes;
};

FitsHeader first_image(std::span<const std::byte> file, const std::string& name) {
  for (std::size_t at = 0; at < file.size();) {
    FitsHeader header(file, at, name);
    if (header.is_true("ZIMAGE")) return header;
    const std::string kind = header.text("XTENSION");
    if (!header.axes().empty() && (at == 0 || kind == "IMAGE") && !header.is_true("GROUPS")) return header;
    if (header.next() <= at) break;
    at = header.next();
  }
  throw Error(ErrorCode::unsupported, name + ": it has no image, at most tables; expected an image of two or three axes");
}

FitsAxes sort_axes(const FitsHeader& header, const std::string& name) {
  FitsAxes axes;
  std::int64_t step = 1;
  for (std::size_t a = 0; a < header.axes().size(); ++a) {
    const FitsAxis axis{static_cast<int>(a) + 1, header.axes()[a], step};
    step *= axis.size;
    if (axis.size == 1) continue;
    const std::string type = header.text("CTYPE" + std::to_string(axis.number));
    if (type == "STOKES" && axes.stokes.number == 0) axes.stokes = axis;
    else if ((type == "TIME" || type == "UTC") && axes.time.number == 0) axes.time = axis;
    else if (axes.count < 3) axes.space[axes.count++] = axis;
    else throw Error(ErrorCode::unsupported, name + ": more than three axes of more than one point, beside STOKES and TIME");
  }
  return axes;
}

/// How numbers become values: FITS has no unsigned ones, but an offset for them.
struct FitsValues {
  ScalarType stored = ScalarType::uint8, type = ScalarType::uint8;
  bool flip = false;  // the highest bit: to or from numbers without a sign
  double scale = 1, zero = 0;
  std::optional<std::int64_t> blank;
  bool same() const { return stored == type || flip; }
};

FitsValues values_of(const FitsHeader& header) {
  FitsValues of;
  of.scale = header.real("BSCALE").value_or(1);
  of.zero = header.real("BZERO").value_or(0);
  const int bits = header.bits();
  of.stored = bits == 8 ? ScalarType::uint8 : bits == 16 ? ScalarType::int16 : bits == 32 ? ScalarType::int32 : bits == 64 ? ScalarType::int64 : bits == -32 ? ScalarType::float32 : ScalarType::float64;
  of.type = of.stored;
  for (const char* key : {"ZBLANK", "BLANK"})
    if (bits > 0 && !header.text(key).empty()) of.blank = header.whole(key, 0);
  const bool plain = of.scale == 1 && of.zero == 0;
  if (bits < 0) {
    if (!plain) of.type = ScalarType::float64;
  } else if (!of.blank && of.scale == 1 && of.zero == (bits == 8 ? -128 : std::ldexp(1.0, bits - 1))) {
    of.flip = true;
    of.type = bits == 8 ? ScalarType::int8 : bits == 16 ? ScalarType::uint16 : bits == 32 ? ScalarType::uint32 : ScalarType::uint64;
  } else if (!plain || of.blank) {
    of.type = bits <= 16 ? ScalarType::float32 : ScalarType::float64;
  }
  return of;
}

template <class From, class To>
void scale_row(const FitsValues& of, std::span<const std::byte> from, std::span<std::byte> to) {
  for (std::size_t i = 0; i < from.size() / sizeof(From); ++i) {
    From number{};
    std::memcpy(&number, from.data() + i * sizeof(From), sizeof number);
    To value = static_cast<To>(of.zero + of.scale * static_cast<double>(number));
    if constexpr (std::is_integral_v<From>)
      if (of.blank && std::in_range<From>(*of.blank) && number == static_cast<From>(*of.blank)) value = std::numeric_limits<To>::quiet_NaN();
    std::memcpy(to.data() + i * sizeof(To), &value, sizeof value);
  }
}

/// One row of numbers in the machine's order, as values.
void convert(const FitsValues& of, std::span<std::byte> row, std::span<std::byte> to) {
  const std::size_t width = size_of(of.stored);
  if (of.same()) {
    if (of.flip)
      for (std::size_t at = width - 1; at < row.size(); at += width) row[at] ^= std::byte{0x80};
    std::memcpy(to.data(), row.data(), row.size());
    return;
  }
  std::visit(
      [&](auto one) {
        using From = std::remove_const_t<typename decltype(one)::value_type>;
        of.type == ScalarType::float32 ? scale_row<From, float>(of, row, to) : scale_row<From, double>(of, row, to);
      },
      scalar_span(of.stored, {}));
}

/// Places along straight axes of one unit, else points 1 apart: degrees of the sky and a frequency have no common length.
void place(Imported& imported, const FitsHeader& header, const FitsAxes& axes, const std::string& name) {
  std::array<double, 3> origin{};
  std::array<std::array<double, 3>, 3> step{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  bool straight = axes.count > 0;
  std::string said;
  for (std::size_t a = 0; a < axes.count; ++a) {
    const std::string n = std::to_string(axes.space[a].number), type = header.text("CTYPE" + n), unit = header.text("CUNIT" + n);
    const std::optional<double> delta = header.real("CDELT" + n);
    imported.axes[a] = {type, unit};
    if (!type.empty()) said += (said.empty() ? "" : ", ") + type + (unit.empty() ? "" : " in " + unit);
    straight = straight && delta && *delta != 0 && type.find("--") == std::string::npos && unit == header.text("CUNIT" + std::to_string(axes.space[0].number));
    for (std::size_t b = 0; b < axes.count; ++b)
      if (b != a && header.real("PC" + n + "_" + std::to_string(axes.space[b].number)).value_or(0) != 0) straight = false;
    if (!straight) continue;
    step[a][a] = *delta;
    origin[a] = header.real("CRVAL" + n).value_or(0) + (1 - header.real("CRPIX" + n).value_or(0)) * *delta;
  }
  if (!straight) {
    origin = {};
    for (std::size_t a = 0; a < 3; ++a) step[a][a] = 1;
    imported.axes = {};
    imported.notes.push_back("points 1 apart" + (said.empty() ? std::string() : "; the axes are " + said));
  }
  place_image(imported.blocks.front(), {axes.space[0].size, axes.space[1].size, axes.space[2].size}, origin, step, name);
}

std::string array_name(const FitsHeader& header, const FitsAxes& axes, std::int64_t s) {
  const std::string extension = header.text("EXTNAME"), type = header.text("BTYPE");
  const std::string base = !extension.empty() && extension != "COMPRESSED_IMAGE" ? extension : !type.empty() ? type : "intensity";
  if (axes.stokes.number == 0) return base;
  const std::string n = std::to_string(axes.stokes.number);
  const double code = header.real("CRVAL" + n).value_or(1) + (static_cast<double>(s) + 1 - header.real("CRPIX" + n).value_or(0)) * header.real("CDELT" + n).value_or(1);
  static constexpr std::array<const char*, 4> kStokes{"I", "Q", "U", "V"};
  return code == 1 || code == 2 || code == 3 || code == 4 ? "Stokes " + std::string(kStokes[static_cast<std::size_t>(code) - 1]) : base + " " + std::to_string(s);
}

}  // namespace

Imported read_fits(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const MappedFile file(request.file);
  const FitsHeader found = first_image(file.bytes(), name);
  const bool tiles = found.is_true("ZIMAGE");
  const FitsHeader header = tiles ? found.unpacked() : found;
  if (!tiles && (header.data() > file.bytes().size() || header.data_bytes() > file.bytes().size() - header.data()))
    throw Error(ErrorCode::bad_data, name + ": is cut off: " + std::to_string(header.data_bytes()) + " bytes of values declared, " +
                                         std::to_string(file.bytes().size() - std::min(header.data(), file.bytes().size())) + " present");
  const FitsAxes axes = sort_axes(header, name);
  Imported imported;
  imported.times.clear();
  const std::string n = std::to_string(axes.time.number);
  for (std::int64_t t = 0; t < axes.time.size; ++t)
    imported.times.push_back(axes.time.number == 0 ? 0 : header.real("CRVAL" + n).value_or(0) + (static_cast<double>(t) + 1 - header.real("CRPIX" + n).value_or(0)) * header.real("CDELT" + n).value_or(1));
  check_step(request, imported.times.size());
  if (request.times_only) return imported;
  const FitsValues of = values_of(header);
  const std::int64_t points = checked_product({axes.space[0].size, axes.space[1].size, axes.space[2].size}, name);
  check_bytes(request, static_cast<std::uint64_t>(checked_product({points, axes.stokes.size, static_cast<std::int64_t>(size_of(of.type))}, name)), name);
  Block& block = imported.blocks.emplace_back();
  place(imported, header, axes, name);
  const FitsData data = tiles ? unpack_fits_tiles(file.bytes(), found, header, request) : FitsData{file.bytes().subspan(header.data(), header.data_bytes()), nullptr};
  const std::size_t width = size_of(of.stored), length = static_cast<std::size_t>(axes.space[0].size);
  const auto step = static_cast<std::size_t>(std::max<std::int64_t>(axes.space[0].step, 1));
  std::vector<std::byte> row(length * width), values(length * size_of(of.type));
  for (std::int64_t s = 0; s < axes.stokes.size; ++s) {
    AppendedFile<std::byte> out(request, "array_" + std::to_string(s) + ".bin");
    for (std::int64_t z = 0; z < axes.space[2].size; ++z)
      for (std::int64_t y = 0; y < axes.space[1].size; ++y) {
        const std::int64_t first = s * axes.stokes.step + request.step * axes.time.step + z * axes.space[2].step + y * axes.space[1].step;
        const std::byte* from = data.bytes.data() + static_cast<std::size_t>(first) * width;
        if (step == 1) std::memcpy(row.data(), from, row.size());
        else
          for (std::size_t i = 0; i < length; ++i) std::memcpy(row.data() + i * width, from + i * step * width, width);
        swap_bytes(row, width);
        convert(of, row, values);
        out.add(values);
        if (y == 0) request.progress(static_cast<double>(s * axes.space[2].size + z + 1) / static_cast<double>(axes.stokes.size * axes.space[2].size));
      }
    FileArray& array = block.arrays.emplace_back();
    array.name = array_name(header, axes, s);
    array.unit = header.text("BUNIT");
    array.type = of.type;
    std::tie(array.values, array.storage) = out.finish();
  }
  return imported;
}

}  // namespace isostrata
