#include <algorithm>
#include <charconv>
#include <cstring>

#include "import/bytes/half_number.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/swap_bytes.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

/// What follows 'key': in the header, a Python dictionary as numpy writes it.
std::string_view value_of(std::string_view header, std::string_view key, const std::string& name) {
  const auto at = header.find("'" + std::string(key) + "'");
  const auto colon = at == std::string_view::npos ? at : header.find(':', at);
  if (colon == std::string_view::npos) throw Error(ErrorCode::bad_data, name + ": its header has no '" + std::string(key) + "'");
  header.remove_prefix(colon + 1);
  header.remove_prefix(std::min(header.find_first_not_of(' '), header.size()));
  return header;
}

bool is_half(std::string_view descr) { return descr.size() > 5 && descr.substr(2, 3) == "f2'"; }

ScalarType type_of(std::string_view descr, const std::string& name) {
  if (is_half(descr)) return ScalarType::float32;
  static constexpr std::pair<std::string_view, ScalarType> kTypes[] = {
      {"i1", ScalarType::int8},   {"u1", ScalarType::uint8},  {"b1", ScalarType::uint8},  {"i2", ScalarType::int16},   {"u2", ScalarType::uint16},
      {"i4", ScalarType::int32},  {"u4", ScalarType::uint32}, {"i8", ScalarType::int64},  {"u8", ScalarType::uint64},  {"f4", ScalarType::float32},
      {"f8", ScalarType::float64}};
  for (const auto& [text, type] : kTypes)
    if (descr.substr(2, 3) == std::string(text) + "'") return type;
  throw Error(ErrorCode::unsupported, name + ": an array of type " + std::string(descr.substr(0, std::min(descr.find(','), std::size_t{24}))) +
                                          "; expected whole or real numbers of at most 8 bytes");
}

std::vector<std::int64_t> shape_of(std::string_view text, const std::string& name) {
  std::vector<std::int64_t> shape;
  text.remove_prefix(std::min<std::size_t>(1, text.size()));
  text = text.substr(0, text.find(')'));
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(" ,"), text.size()));
    if (text.empty()) return shape;
    std::int64_t size = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size);
    if (error == std::errc{} && size == 0) throw Error(ErrorCode::unsupported, name + ": an array without values");
    if (error != std::errc{} || size < 1 || shape.size() >= 8)
      throw Error(ErrorCode::bad_data, name + ": a shape that makes no sense; expected one to four axes of at least 1");
    shape.push_back(size);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
}

/// From the order of Fortran: the file's first axis, our last, runs fastest.
void turn_axes(std::span<const std::byte> from, const std::array<std::int64_t, 3>& dims, std::size_t width, std::span<std::byte> to) {
  std::size_t at = 0;
  for (std::int64_t i = 0; i < dims[0]; ++i)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t k = 0; k < dims[2]; ++k, at += width)
        std::memcpy(to.data() + static_cast<std::size_t>(i + dims[0] * (j + dims[1] * k)) * width, from.data() + at, width);
}

}  // namespace

// NumPy's format, versions 1 to 3 (NEP 1): magic, version, length of the header, header, numbers. The last axis is x, as arrays of pictures have it; a
// fourth axis of at most 16 at the end is the components of each point.
Imported read_numpy(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  const auto file = std::make_shared<const MappedFile>(request.file);
  const std::string_view bytes(reinterpret_cast<const char*>(file->bytes().data()), file->bytes().size());
  if (bytes.size() < 12) throw Error(ErrorCode::bad_data, name + ": ends within its header");
  const bool wide = bytes[6] >= 2;
  std::uint32_t length = 0;
  for (int b = wide ? 3 : 1; b >= 0; --b) length = length << 8 | static_cast<unsigned char>(bytes[static_cast<std::size_t>(8 + b)]);
  const std::size_t begin = wide ? 12 : 10;
  if (length > bytes.size() - begin) throw Error(ErrorCode::bad_data, name + ": ends within its header");
  const std::string_view header = bytes.substr(begin, length);
  const std::string_view descr = value_of(header, "descr", name);
  const ScalarType type = type_of(descr, name);
  const bool half = is_half(descr), swap = descr.size() > 1 && descr[1] == '>' && size_of(type) > 1;
  const bool fortran = value_of(header, "fortran_order", name).starts_with("True");
  std::vector<std::int64_t> shape = shape_of(value_of(header, "shape", name), name);

  int components = 1;
  if (!fortran && shape.size() == 4 && shape.back() <= 16) {
    components = static_cast<int>(shape.back());
    shape.pop_back();
  }
  if (shape.empty() || shape.size() > 3)
    throw Error(ErrorCode::unsupported, name + ": " + std::to_string(shape.size()) + " axes; expected one to three, or a fourth of at most 16 components");
  std::array<std::int64_t, 3> dims{1, 1, 1};
  for (std::size_t a = 0; a < shape.size(); ++a) dims[shape.size() - 1 - a] = shape[a];
  const std::int64_t points = checked_product({dims[0], dims[1], dims[2]}, name);
  const std::int64_t size = checked_product({points, components, static_cast<std::int64_t>(half ? 2 : size_of(type))}, name);
  const std::size_t present = bytes.size() - begin - length;
  if (static_cast<std::uint64_t>(size) > present)
    throw Error(ErrorCode::bad_data, name + ": " + std::to_string(size) + " bytes of numbers declared, " + std::to_string(present) + " present");

  Imported imported;
  Block block;
  place_image(block, dims, {0, 0, 0}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, name);
  FileArray array;
  array.name = request.file.stem().string();
  array.type = type;
  array.components = components;
  const std::size_t width = half ? 2 : size_of(type), first = begin + length;
  const std::span<const std::byte> from = file->bytes().subspan(first, static_cast<std::size_t>(size));
  const bool in_our_order = !fortran || shape.size() == 1;
  if (in_our_order && !swap && !half && components == 1 && first % width == 0) {
    array.values = from;
    array.storage = file;
  } else {
    check_bytes(request, from.size(), name);
    auto [storage, to] = allocate<std::byte>(from.size());
    if (in_our_order)
      std::memcpy(to.data(), from.data(), to.size());
    else
      turn_axes(from, dims, width, to);
    if (swap) swap_bytes(to, width);
    array.values = to;
    array.storage = storage;
    if (half) {
      check_bytes(request, 2 * to.size(), name);
      auto [wider, floats] = allocate<float>(to.size() / 2);
      half_numbers(to, floats);
      array.values = std::as_bytes(std::span<const float>(floats));
      array.storage = wider;
    }
  }
  block.arrays.push_back(std::move(array));
  imported.blocks.push_back(std::move(block));
  imported.notes.push_back("axes: the array's last is x; points 1 apart");
  return imported;
}

}  // namespace isostrata
