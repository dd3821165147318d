#include "import/vtk/check_legacy_cells.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/error.h"

namespace isostrata {
namespace {

std::string_view skip_blanks(std::string_view text) {
  const auto at = text.find_first_not_of(" \t\r\n");
  return at == std::string_view::npos ? std::string_view{} : text.substr(at);
}

std::optional<std::int64_t> take_integer(std::string_view& text) {
  text = skip_blanks(text);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

bool is_keyword(std::string_view text, std::string_view keyword) {
  return text.size() > keyword.size() &&
         std::equal(keyword.begin(), keyword.end(), text.begin(),
                    [](char a, char b) { return a == std::toupper(static_cast<unsigned char>(b)); }) &&
         std::isspace(static_cast<unsigned char>(text[keyword.size()]));
}

/// What follows the first line that begins with `keyword`; empty if there is none.
std::string_view after_keyword(std::string_view text, std::string_view keyword) {
  for (auto newline = text.find('\n'); newline != std::string_view::npos; newline = text.find('\n', newline + 1)) {
    std::string_view line = text.substr(newline + 1);
    if (is_keyword(line, keyword)) return line.substr(keyword.size());
  }
  return {};
}

}  // namespace

void check_legacy_counts(std::span<const std::byte> file, const std::string& name) {
  const std::string_view head(reinterpret_cast<const char*>(file.data()), std::min<std::size_t>(file.size(), 1 << 20));
  for (const char* keyword : {"POINTS", "X_COORDINATES", "Y_COORDINATES", "Z_COORDINATES"}) {
    std::string_view rest = after_keyword(head, keyword);
    const auto count = take_integer(rest);
    if (count && (*count < 0 || static_cast<std::uint64_t>(*count) > file.size()))
      throw Error(ErrorCode::bad_data,
                  name + ": " + keyword + " " + std::to_string(*count) + " declared in a file of " + std::to_string(file.size()) + " bytes");
  }
}

void check_legacy_cells(std::span<const std::byte> file, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  std::string_view rest = after_keyword(text, "CELLS");
  const auto cells = take_integer(rest), size = take_integer(rest);
  if (!cells || !size) return;  // no cells, or nothing that VTK would read as a count
  const auto refuse = [&](std::int64_t cell, const std::string& why) {
    throw Error(ErrorCode::bad_data, name + ": CELLS " + std::to_string(*cells) + " " + std::to_string(*size) +
                                         " declared, but cell " + std::to_string(cell) + " " + why);
  };
  const auto end_of_line = rest.find('\n');
  if (end_of_line == std::string_view::npos) return;
  rest.remove_prefix(end_of_line + 1);
  if (is_keyword(skip_blanks(rest), "OFFSETS")) return;
  const std::string_view head = text.substr(0, std::min<std::size_t>(text.size(), 1024));
  const bool binary = !after_keyword(head, "BINARY").empty();

  const auto next = [&]() -> std::optional<std::int64_t> {
    if (!binary) return take_integer(rest);
    if (rest.size() < 4) return std::nullopt;
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(rest[static_cast<std::size_t>(i)]);
    rest.remove_prefix(4);
    return static_cast<std::int32_t>(value);
  };
  std::int64_t left = *size;
  for (std::int64_t cell = 0; cell < *cells; ++cell) {
    const auto points = next();
    if (!points) refuse(cell, "is not there");
    if (*points < 0 || *points > left - 1)
      refuse(cell, "has " + std::to_string(*points) + " points, with " + std::to_string(left) + " integers left");
    left -= *points + 1;
    for (std::int64_t v = 0; v < *points; ++v)
      if (!next()) refuse(cell, "ends before its points are there");
  }
  if (left != 0) refuse(*cells, "does not follow although " + std::to_string(left) + " integers are left");
}

}  // namespace isostrata
