// Loading PLOT3D files and reading numbers from them under one hypothesis.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "import/meshes/plot3d_layout.h"

namespace isostrata {
namespace {

template <class T>
T swapped(T value) {
  std::array<std::byte, sizeof(T)> bytes;
  std::memcpy(bytes.data(), &value, sizeof(T));
  std::reverse(bytes.begin(), bytes.end());
  std::memcpy(&value, bytes.data(), sizeof(T));
  return value;
}

template <class T>
T load(const std::byte* from, bool big_endian) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return big_endian ? swapped(value) : value;
}

bool looks_like_text(const std::vector<std::byte>& bytes) {
  const std::size_t n = std::min<std::size_t>(bytes.size(), 4096);
  return std::all_of(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n), [](std::byte b) {
    const auto c = std::to_integer<unsigned char>(b);
    return (c >= 32 && c < 127) || c == '\n' || c == '\r' || c == '\t' || c == '\f';
  });
}

/// Fortran list-directed text: numbers between blanks or commas, "n*value" for repeats, D for an exponent.
std::vector<double> parse_text(const std::string& name, const std::vector<std::byte>& bytes, std::uint64_t max_bytes) {
  std::vector<double> numbers;
  const char* at = reinterpret_cast<const char*>(bytes.data());
  const char* const end = at + bytes.size();
  const auto separator = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == ',' || c == '\f'; };
  const auto refuse = [&](const char* from) {
    std::string word(from, std::find_if(from, std::min(end, from + 40), separator));
    std::replace_if(
        word.begin(), word.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
    throw Error(ErrorCode::bad_data,
                name + ": word " + std::to_string(numbers.size() + 1) + " is '" + word + "'; expected a number");
  };
  while (at != end) {
    if (separator(*at)) {
      ++at;
      continue;
    }
    const char* const stop = std::find_if(at, end, separator);
    char word[64];
    if (stop - at >= static_cast<std::ptrdiff_t>(sizeof word)) refuse(at);
    char* const word_end = std::transform(at, stop, word, [](char c) { return c == 'D' || c == 'd' ? 'e' : c; });
    std::uint64_t repeat = 1;
    const char* value_text = word;
    if (char* const star = std::find(word, word_end, '*'); star != word_end) {
      if (std::from_chars(word, star, repeat).ptr != star) refuse(at);
      value_text = star + 1;
    }
    if (value_text != word_end && *value_text == '+') ++value_text;
    double value = 0;
    const auto [parsed, error] = std::from_chars(value_text, static_cast<const char*>(word_end), value);
    if (parsed != word_end || (error != std::errc{} && error != std::errc::result_out_of_range)) refuse(at);
    if (error == std::errc::result_out_of_range) {  // from_chars leaves the value as it was; strtod makes it infinite, or 0
      *word_end = '\0';
      value = std::strtod(value_text, nullptr);
    }
    if (repeat > max_bytes / 8 || (numbers.size() + repeat) * 8 > max_bytes)
      throw Error(ErrorCode::too_large, name + ": more numbers than the limit of " + std::to_string(max_bytes) + " bytes holds");
    numbers.insert(numbers.end(), repeat, value);
    at = stop;
  }
  return numbers;
}

}  // namespace

Plot3dContents load_plot3d(const std::filesystem::path& file, std::uint64_t max_bytes) {
  Plot3dContents contents;
  contents.name = file.filename().string();
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(ErrorCode::not_found, contents.name + ": cannot be opened for reading");
  const std::uintmax_t size = std::filesystem::file_size(file);
  if (size > max_bytes)
    throw Error(ErrorCode::too_large,
                contents.name + ": " + std::to_string(size) + " bytes, the limit is " + std::to_string(max_bytes));
  contents.bytes.resize(size);
  in.read(reinterpret_cast<char*>(contents.bytes.data()), static_cast<std::streamsize>(size));
  contents.bytes.resize(static_cast<std::size_t>(in.gcount()));
  if (contents.bytes.empty()) throw Error(ErrorCode::bad_data, contents.name + ": is empty");
  contents.text = looks_like_text(contents.bytes);
  if (contents.text) {
    contents.numbers = parse_text(contents.name, contents.bytes, max_bytes);
    contents.bytes = {};
  }
  return contents;
}

std::string Plot3dFormat::describe(bool text) const {
  if (text) return "text";
  return std::string(big_endian ? "big" : "little") + "-endian " + (real_bytes == 4 ? "single" : "double") + " precision" +
         (marker_bytes ? ", Fortran records" : ", no record marks");
}

std::optional<std::uint64_t> Plot3dCursor::marker() {
  const auto width = static_cast<std::size_t>(format_.marker_bytes);
  if (contents_.bytes.size() - at_ < width) return std::nullopt;
  const std::byte* from = contents_.bytes.data() + at_;
  at_ += width;
  return width == 4 ? load<std::uint32_t>(from, format_.big_endian) : load<std::uint64_t>(from, format_.big_endian);
}

bool Plot3dCursor::open_record(std::size_t payload_bytes) {
  if (contents_.text || format_.marker_bytes == 0) return true;
  const auto length = open_any_record();
  return length && *length == payload_bytes;
}

std::optional<std::size_t> Plot3dCursor::open_any_record() {
  if (contents_.text || format_.marker_bytes == 0) return std::nullopt;
  const auto length = marker();
  if (!length) return std::nullopt;
  record_ = *length;
  record_begin_ = at_;
  return record_;
}

bool Plot3dCursor::close_record() {
  if (contents_.text || format_.marker_bytes == 0) return true;
  if (at_ - record_begin_ != record_) return false;
  const auto length = marker();
  return length && *length == record_;
}

std::optional<std::int64_t> Plot3dCursor::integer() {
  const auto from = skip(1, 4);
  if (!from) return std::nullopt;
  if (!contents_.text) return load<std::int32_t>(contents_.bytes.data() + *from, format_.big_endian);
  const double value = contents_.numbers[*from];
  if (value != std::floor(value) || std::abs(value) > 2147483647.0) return std::nullopt;
  return static_cast<std::int64_t>(value);
}

std::optional<std::size_t> Plot3dCursor::skip(std::size_t count, std::size_t bytes_each) {
  std::size_t length = count;
  if (!contents_.text && __builtin_mul_overflow(count, bytes_each, &length)) return std::nullopt;
  missing_ = 0;
  if (length > size() - at_) {
    missing_ = length - (size() - at_);
    return std::nullopt;
  }
  const std::size_t from = at_;
  at_ += length;
  return from;
}

namespace {

template <class T>
Plot3dReals interleave(const Plot3dContents& contents, const Plot3dFormat& format, std::size_t at, std::size_t count,
                       std::size_t components) {
  auto [storage, values] = allocate<T>(count * components);
  for (std::size_t c = 0; c < components; ++c) {
    const std::size_t first = c * count;
    if (contents.text)
      for (std::size_t i = 0; i < count; ++i) values[i * components + c] = static_cast<T>(contents.numbers[at + first + i]);
    else
      for (std::size_t i = 0; i < count; ++i)
        values[i * components + c] = load<T>(contents.bytes.data() + at + (first + i) * sizeof(T), format.big_endian);
  }
  return {sizeof(T) == 4 ? ScalarType::float32 : ScalarType::float64, std::as_bytes(values), storage};
}

}  // namespace

Plot3dReals read_reals(const Plot3dContents& contents, const Plot3dFormat& format, std::size_t at, std::size_t count,
                       int components) {
  const auto c = static_cast<std::size_t>(components);
  return !contents.text && format.real_bytes == 4 ? interleave<float>(contents, format, at, count, c)
                                                  : interleave<double>(contents, format, at, count, c);
}

std::vector<std::int32_t> read_integers(const Plot3dContents& contents, const Plot3dFormat& format, std::size_t at,
                                        std::size_t count) {
  std::vector<std::int32_t> out(count);
  for (std::size_t i = 0; i < count; ++i)
    out[i] = contents.text ? static_cast<std::int32_t>(std::clamp(contents.numbers[at + i], -2147483648.0, 2147483647.0))
                           : load<std::int32_t>(contents.bytes.data() + at + i * 4, format.big_endian);
  return out;
}

}  // namespace isostrata
