#include "import/vtk/meta_header.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <limits>
#include <sstream>

#include "base/error.h"
#include "import/bytes/parsed_number.h"

namespace isostrata {
namespace {

constexpr std::string_view kBlanks = " \t", kSeparators = "=:";
constexpr std::size_t kLongest = 499;  // MetaIO's buffers have 500 bytes
constexpr std::size_t kLongestName = 200;  // MetaIO has a place for 255
constexpr int kMostHeaderLines = 1000;

std::string shown(std::string_view line) {
  std::string text(line.substr(0, 60));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '?');
  return text;
}

struct ElementType {
  std::string_view name;
  std::uint64_t bytes;
  ScalarType type;
};

const ElementType* element_type(std::string_view name) {
  static constexpr std::array<ElementType, 12> kTypes{{{"MET_CHAR", 1, ScalarType::int8},
                                                       {"MET_UCHAR", 1, ScalarType::uint8},
                                                       {"MET_SHORT", 2, ScalarType::int16},
                                                       {"MET_USHORT", 2, ScalarType::uint16},
                                                       {"MET_INT", 4, ScalarType::int32},
                                                       {"MET_UINT", 4, ScalarType::uint32},
                                                       {"MET_LONG", 4, ScalarType::int32},
                                                       {"MET_ULONG", 4, ScalarType::uint32},
                                                       {"MET_LONG_LONG", 8, ScalarType::int64},
                                                       {"MET_ULONG_LONG", 8, ScalarType::uint64},
                                                       {"MET_FLOAT", 4, ScalarType::float32},
                                                       {"MET_DOUBLE", 8, ScalarType::float64}}};
  if (name.ends_with("_ARRAY")) name.remove_suffix(6);  // of several channels
  const auto at = std::find_if(kTypes.begin(), kTypes.end(), [&](const ElementType& type) { return type.name == name; });
  return at == kTypes.end() ? nullptr : &*at;
}

}  // namespace

std::string_view MetaHeader::field(std::string_view name) const {
  const auto at = fields.find(name);
  return at == fields.end() ? std::string_view() : at->second;
}

std::optional<ScalarType> MetaHeader::type() const {
  const ElementType* const of = element_type(field("ElementType"));
  return of ? std::optional(of->type) : std::nullopt;
}

bool MetaHeader::says_yes(std::string_view text) {
  return !text.empty() && (std::tolower(static_cast<unsigned char>(text[0])) == 't' || text[0] == '1');
}

std::vector<std::int64_t> MetaHeader::sizes() const {
  const auto axes = parsed_number<std::size_t>(field("NDims"));
  if (!axes || *axes < 1 || *axes > 3) return {};
  std::vector<std::int64_t> sizes(*axes);
  std::istringstream numbers{std::string(field("DimSize"))};
  for (std::int64_t& size : sizes)
    if (!(numbers >> size) || size < 1) return {};
  return sizes;
}

std::optional<std::int64_t> MetaHeader::channels() const {
  const std::string_view text = field("ElementNumberOfChannels");
  const auto channels = text.empty() ? std::optional<std::int64_t>(1) : parsed_number<std::int64_t>(text);
  return channels && *channels >= 1 && *channels <= 1000 ? channels : std::nullopt;
}

std::uint64_t MetaHeader::declared_bytes() const {
  const ElementType* const of = element_type(field("ElementType"));
  std::uint64_t bytes = of ? of->bytes : 0;
  const auto times = [&bytes](std::uint64_t count) {
    bytes = count != 0 && bytes > std::numeric_limits<std::uint64_t>::max() / count ? std::numeric_limits<std::uint64_t>::max() : bytes * count;
  };
  std::istringstream sizes{std::string(field("DimSize"))};
  for (std::int64_t size = 0; sizes >> size;) times(static_cast<std::uint64_t>(std::max<std::int64_t>(size, 0)));
  std::int64_t channels = 1;
  std::istringstream(std::string(field("ElementNumberOfChannels"))) >> channels;
  times(static_cast<std::uint64_t>(std::max<std::int64_t>(channels, 1)));
  return bytes;
}

MetaHeader read_meta_header(std::istream& in, std::string_view file) {
  const auto refuse = [&](const std::string& why) { return Error(ErrorCode::bad_data, std::string(file) + ": " + why); };
  MetaHeader header;
  std::string line;
  for (int i = 0; i < kMostHeaderLines && std::getline(in, line); ++i) {
    header.end += line.size() + 1;
    if (line.ends_with('\r')) line.pop_back();
    line.erase(0, std::min(line.find_first_not_of(kBlanks), line.size()));
    if (line.empty()) continue;
    if (line.size() > kLongest) throw refuse("the line '" + shown(line) + "...' has " + std::to_string(line.size()) + " bytes; expected at most 499");
    if (std::any_of(line.begin(), line.end(), [](unsigned char c) { return (c < 32 && c != '\t') || c == 127; }))
      throw refuse("the line '" + shown(line) + "' holds a control character; expected text");
    const auto separator = line.find_first_of(kSeparators);
    const auto value = separator == std::string::npos ? separator : line.find_first_not_of(" \t=:", separator);
    if (value == std::string::npos) throw refuse("the line '" + shown(line) + "' has no value; expected 'Name = value'");
    const std::string name = line.substr(0, line.find_last_not_of(kBlanks, separator == 0 ? 0 : separator - 1) + 1);
    if (name.size() > kLongestName) throw refuse("the name '" + shown(name) + "...' has " + std::to_string(name.size()) + " bytes; expected at most 200");
    line.erase(line.find_last_not_of(kBlanks) + 1);
    if (name == "ElementDataFile") {
      header.data = line.substr(value);
      return header;
    }
    header.fields[name] = line.substr(value);
  }
  throw refuse("expected a line 'ElementDataFile = ...'");
}

}  // namespace isostrata
