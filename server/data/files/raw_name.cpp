#include "data/files/raw_name.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <string>
#include <utility>

#include "base/error.h"
#include "data/files/file_formats.h"
#include "data/files/recognise.h"

namespace isostrata {
namespace {

using Sizes = std::vector<std::int64_t>;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The number at the beginning of the text, which is taken off; nothing if there is none, or it is 0 or too large for an axis.
std::optional<std::int64_t> take_number(std::string_view& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || value < 1 || value > (std::int64_t{1} << 40)) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// "64x64x32", of two to four numbers. One with a point before or behind it is a distance between points, and not a size.
std::optional<Sizes> sizes_with_x(std::string_view name) {
  for (std::size_t at = 0; at < name.size(); ++at) {
    if (!is_digit(name[at]) || (at > 0 && (is_digit(name[at - 1]) || name[at - 1] == '.' || (name[at - 1] == 'x' && at > 1 && is_digit(name[at - 2]))))) continue;
    std::string_view rest = name.substr(at);
    Sizes sizes;
    while (const auto size = take_number(rest)) {
      sizes.push_back(*size);
      if (rest.size() < 2 || rest[0] != 'x' || !is_digit(rest[1])) break;
      rest.remove_prefix(1);
    }
    const bool decimal = rest.size() > 1 && rest[0] == '.' && is_digit(rest[1]);
    if (sizes.size() >= 2 && sizes.size() <= 4 && !decimal) return sizes;
  }
  return std::nullopt;
}

std::vector<std::string_view> words_of(std::string_view name) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < name.size();) {
    const auto end = std::find_if(name.begin() + static_cast<std::ptrdiff_t>(at), name.end(), [](unsigned char c) { return !std::isalnum(c); }) - name.begin();
    if (static_cast<std::size_t>(end) > at) words.push_back(name.substr(at, static_cast<std::size_t>(end) - at));
    at = static_cast<std::size_t>(end) + 1;
  }
  return words;
}

/// Values of the sizes; nothing beyond 2^62.
std::optional<std::uint64_t> product(const Sizes& sizes) {
  std::uint64_t all = 1;
  for (const std::int64_t size : sizes) {
    if (all > (std::uint64_t{1} << 62) / static_cast<std::uint64_t>(size)) return std::nullopt;
    all *= static_cast<std::uint64_t>(size);
  }
  return all;
}

/// Of so many bytes a value.
std::optional<ScalarType> usual_type(std::uint64_t bytes, std::uint64_t values) {
  for (const auto& [width, type] : {std::pair{1, ScalarType::uint8}, {2, ScalarType::uint16}, {4, ScalarType::float32}, {8, ScalarType::float64}})
    if (bytes == values * static_cast<std::uint64_t>(width)) return type;
  return std::nullopt;
}

/// The type that so many values have in so many bytes; nothing if none does.
std::optional<ScalarType> fitting_type(const Sizes& sizes, std::optional<ScalarType> said, std::uint64_t bytes) {
  const auto values = product(sizes);
  if (!values || *values > (std::uint64_t{1} << 58)) return std::nullopt;
  if (!said) return usual_type(bytes, *values);
  return *values * size_of(*said) == bytes ? said : std::nullopt;
}

std::optional<Sizes> three_numbers(const std::vector<std::string_view>& words, std::optional<ScalarType> said, std::uint64_t bytes) {
  for (std::size_t w = 0; w + 3 <= words.size(); ++w) {
    Sizes sizes;
    for (std::size_t i = w; i < w + 3; ++i) {
      std::string_view word = words[i];
      const auto number = take_number(word);
      if (number && word.empty()) sizes.push_back(*number);
    }
    if (sizes.size() == 3 && fitting_type(sizes, said, bytes)) return sizes;
  }
  return std::nullopt;
}

}  // namespace

std::optional<ScalarType> scalar_type_named(std::string_view word) {
  static constexpr std::array<std::pair<ScalarType, std::string_view>, 10> kWords{{
      {ScalarType::uint8, " uint8 u8 uchar byte ubyte 8bit unsignedchar "},
      {ScalarType::int8, " int8 i8 s8 char schar "},
      {ScalarType::uint16, " uint16 u16 ushort word 16bit unsignedshort "},
      {ScalarType::int16, " int16 i16 s16 short "},
      {ScalarType::uint32, " uint32 u32 uint unsignedint "},
      {ScalarType::int32, " int32 i32 s32 int integer "},
      {ScalarType::uint64, " uint64 u64 "},
      {ScalarType::int64, " int64 i64 s64 long "},
      {ScalarType::float32, " float32 f32 float single real32 32bit "},
      {ScalarType::float64, " float64 f64 double real64 64bit "},
  }};
  for (const auto& [type, names] : kWords)
    if (!word.empty() && names.find(" " + std::string(word) + " ") != std::string_view::npos) return type;
  return std::nullopt;
}

bool says_raw_sizes(std::string_view file) { return ends_with_one_of(file, format_of(FileKind::raw).extensions) && sizes_with_x(file); }

std::optional<RawName> raw_name(std::string_view name, std::uint64_t bytes) {
  const std::string file = small_letters(std::string(name));
  if (!ends_with_one_of(file, format_of(FileKind::raw).extensions)) return std::nullopt;
  const std::vector<std::string_view> words = words_of(file);
  RawName raw;
  for (const std::string_view word : words) {
    if (const auto type = scalar_type_named(word)) raw.type = type;
    if (word == "be" || word == "msb" || word == "big" || word == "bigendian") raw.big_endian = true;
    if (word == "le" || word == "lsb" || word == "little" || word == "littleendian") raw.big_endian = false;
  }
  raw.says_type = raw.type.has_value();
  const auto sizes = sizes_with_x(file);
  if (!sizes) {
    const auto three = three_numbers(words, raw.type, bytes);
    if (!three) return std::nullopt;
    raw.sizes = *three;
  } else {
    raw.sizes = *sizes;
  }
  const auto type = fitting_type(raw.sizes, raw.type, bytes);
  if (!type) {
    std::string text;
    for (const std::int64_t size : raw.sizes) text += (text.empty() ? "" : "x") + std::to_string(size);
    const auto values = product(raw.sizes);
    const std::string declared = raw.type && values ? " " + std::string(to_string(*raw.type)) + ", which is " + std::to_string(*values * size_of(*raw.type)) + " bytes"
                                                    : " values, of 1, 2, 4 or 8 bytes each";
    throw Error(ErrorCode::bad_data, std::string(name) + ": its name says " + text + declared + "; the file has " + std::to_string(bytes));
  }
  raw.type = type;
  return raw;
}

}  // namespace isostrata
