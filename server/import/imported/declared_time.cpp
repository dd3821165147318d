#include "import/imported/declared_time.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "data/files/file_beginning.h"
#include "import/imported/xml_arrays.h"

namespace isostrata {
namespace {

std::optional<double> number(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n\""), text.size()));
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// A range has 11 digits; what is appended is looked up.
std::optional<double> of_xml(const std::filesystem::path& file, std::string_view head, std::string_view array) {
  const auto name = head.find("Name=\"" + std::string(array) + "\"");
  const auto open = name == std::string_view::npos ? name : head.rfind('<', name);
  const auto close = name == std::string_view::npos ? name : head.find('>', name);
  if (open == std::string_view::npos || close == std::string_view::npos) return std::nullopt;
  const std::string_view element = head.substr(open, close - open);
  if (element.find("format=\"ascii\"") != std::string_view::npos) return number(head.substr(close + 1));
  if (element.find("format=\"appended\"") != std::string_view::npos)
    if (const auto xml = XmlArrays::open(file))
      if (const auto value = xml->field(array); value && std::isfinite(*value)) return value;
  const auto range = element.find("RangeMin=\"");
  return range == std::string_view::npos ? std::nullopt : number(element.substr(range + 10));
}

/// "TIME 1 1 double", a line end, then the number: as text, or eight bytes of which the first is the highest.
std::optional<double> of_legacy(std::string_view head, std::string_view array) {
  for (const std::string type : {"double", "float"}) {
    const std::string line = "\n" + std::string(array) + " 1 1 " + type;
    const auto at = head.find(line), end = at == std::string_view::npos ? at : head.find_first_not_of(" \t\r", at + line.size());
    if (end == std::string_view::npos || head[end] != '\n') continue;
    const std::string_view rest = head.substr(end + 1);
    if (head.find("\nASCII") != std::string_view::npos && head.find("\nASCII") < at) return number(rest);
    const std::size_t width = type == "double" ? 8 : 4;
    if (rest.size() < width) return std::nullopt;
    std::uint64_t bits = 0;
    for (std::size_t b = 0; b < width; ++b) bits = bits << 8 | static_cast<unsigned char>(rest[b]);
    const double value = width == 8 ? std::bit_cast<double>(bits) : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    if (std::isfinite(value)) return value;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> declared_time(const std::filesystem::path& file) {
  std::string head = file_beginning(file, 64 << 10);
  const bool xml = head.find("<VTKFile") != std::string::npos;
  if (xml) std::replace(head.begin(), head.end(), '\'', '"');  // OpenFOAM's lists have these
  for (const char* array : {"TimeValue", "TIME"})
    if (const auto time = xml ? of_xml(file, head, array) : of_legacy(head, array)) return time;
  return std::nullopt;
}

}  // namespace isostrata
