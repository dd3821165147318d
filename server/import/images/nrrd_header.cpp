#include "import/images/nrrd_header.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "base/error.h"
#include "import/bytes/parsed_number.h"
#include "import/bytes/trimmed.h"
#include "import/imported/imported.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostNrrdAxes = 16, kMostDataFiles = 65536;

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> out;
  for (;;) {
    text = trimmed(text);
    if (text.empty()) return out;
    const auto end = std::min(text.find_first_of(" \t"), text.size());
    out.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
}

std::optional<double> real(std::string_view text) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  return parsed_number<double>(text);
}

std::optional<std::int64_t> integer(std::string_view text) { return parsed_number<std::int64_t>(trimmed(text)); }

/// Fields of one header, and how to complain about them.
class HeaderFields {
 public:
  explicit HeaderFields(std::string name) : name_(std::move(name)) {}

  std::map<std::string, std::string> values;

  [[noreturn]] void refuse(const std::string& field, const std::string& expected) const {
    const auto at = values.find(field);
    throw Error(ErrorCode::bad_data,
                name_ + ": " + (at == values.end() ? "no field '" + field + "'" : field + " '" + at->second.substr(0, 80) + "'") +
                    "; expected " + expected);
  }
  const std::string* find(const std::string& field) const {
    const auto at = values.find(field);
    return at == values.end() ? nullptr : &at->second;
  }
  const std::string& need(const std::string& field, const std::string& expected) const {
    const std::string* value = find(field);
    if (!value) refuse(field, expected);
    return *value;
  }
  std::vector<std::string> per_axis(const std::string& field, std::size_t axes) const {
    const std::string* value = find(field);
    if (!value) return {};
    auto out = words(*value);
    if (out.size() != axes) refuse(field, std::to_string(axes) + " entries");
    return out;
  }
  /// Words between quotes; some write them without. As many as there are, at most `most`.
  std::vector<std::string> quoted(const std::string& field, std::size_t most) const {
    std::vector<std::string> out;
    const std::string* value = find(field);
    for (std::string_view left = value ? std::string_view(*value) : std::string_view(); out.size() < most && !(left = trimmed(left)).empty();) {
      const bool opened = left.front() == '"';
      if (opened) left.remove_prefix(1);
      const std::size_t end = std::min(left.find_first_of(opened ? "\"" : " \t"), left.size());
      out.emplace_back(left.substr(0, end) == "???" ? "" : left.substr(0, end));
      left.remove_prefix(std::min(end + 1, left.size()));
    }
    return out;
  }
  std::optional<double> finite(const std::string& field, const std::string& word) const {
    if (word == "???" || lower(word) == "nan") return std::nullopt;
    const auto value = real(word);
    if (!value) refuse(field, "numbers or nan");
    return std::isfinite(*value) ? value : std::nullopt;
  }
  /// "(a,b,c)" with up to three numbers, missing ones 0.
  std::array<double, 3> vector(const std::string& field, std::string_view text) const {
    text = trimmed(text);
    if (text.size() < 3 || text.front() != '(' || text.back() != ')') refuse(field, "vectors as (a,b,c) or none");
    text = text.substr(1, text.size() - 2);
    std::array<double, 3> out{};
    for (std::size_t i = 0;; ++i) {
      const auto comma = text.find(',');
      const auto value = real(text.substr(0, comma));
      if (i >= 3 || !value || !std::isfinite(*value)) refuse(field, "vectors of up to three finite numbers");
      out[i] = *value;
      if (comma == std::string_view::npos) return out;
      text.remove_prefix(comma + 1);
    }
  }
  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

ScalarType parse_type(const HeaderFields& fields) {
  static const std::map<std::string, ScalarType> kTypes = [] {
    std::map<std::string, ScalarType> types{{"float", ScalarType::float32}, {"double", ScalarType::float64}};
    const auto add = [&](ScalarType type, std::initializer_list<const char*> names) {
      for (const char* n : names) types[n] = type;
    };
    add(ScalarType::int8, {"signed char", "int8", "int8_t"});
    add(ScalarType::uint8, {"uchar", "unsigned char", "uint8", "uint8_t"});
    add(ScalarType::int16, {"short", "short int", "signed short", "signed short int", "int16", "int16_t"});
    add(ScalarType::uint16, {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"});
    add(ScalarType::int32, {"int", "signed int", "int32", "int32_t"});
    add(ScalarType::uint32, {"uint", "unsigned int", "uint32", "uint32_t"});
    add(ScalarType::int64,
        {"longlong", "long long", "long long int", "signed long long", "signed long long int", "int64", "int64_t"});
    add(ScalarType::uint64, {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"});
    return types;
  }();
  const std::string type = lower(fields.need("type", "a scalar type"));
  if (type == "block") throw Error(ErrorCode::unsupported, fields.name() + ": type block; expected numbers");
  const auto at = kTypes.find(type);
  if (at == kTypes.end()) fields.refuse("type", "one of NRRD's scalar types");
  return at->second;
}

NrrdEncoding parse_encoding(const HeaderFields& fields) {
  const std::string encoding = lower(fields.need("encoding", "raw, text, hex, gzip or bzip2"));
  if (encoding == "raw") return NrrdEncoding::raw;
  if (encoding == "txt" || encoding == "text" || encoding == "ascii") return NrrdEncoding::text;
  if (encoding == "hex") return NrrdEncoding::hex;
  if (encoding == "gz" || encoding == "gzip") return NrrdEncoding::gzip;
  if (encoding == "bz2" || encoding == "bzip2") return NrrdEncoding::bzip2;
  throw Error(ErrorCode::unsupported,
              fields.name() + ": encoding '" + encoding.substr(0, 40) + "'; expected raw, text, hex, gzip or bzip2");
}

/// Splits "none (1,0,0) (0, 1, 0)" where blanks may also stand inside the parentheses.
std::vector<std::string> split_vectors(const std::string& text) {
  std::vector<std::string> out;
  std::string_view rest = trimmed(text);
  while (!rest.empty()) {
    const auto end =
        rest.front() == '(' ? std::min(rest.find(')'), rest.size() - 1) + 1 : std::min(rest.find_first_of(" \t("), rest.size());
    out.emplace_back(rest.substr(0, end));
    rest = trimmed(rest.substr(end));
  }
  return out;
}

/// "data file": NAME, or "LIST", or "FORMAT MIN MAX STEP" with one %d in FORMAT.
std::vector<std::string> parse_data_files(const HeaderFields& fields, const std::vector<std::string>& list) {
  const std::string* field = fields.find("data file");
  if (!field) return {};
  const auto parts = words(*field);
  if (parts.empty()) fields.refuse("data file", "a file name");
  if (parts[0] == "LIST") {
    if (list.empty()) fields.refuse("data file", "file names on the lines that follow");
    return list;
  }
  if (parts.size() < 4 || parts[0].find('%') == std::string::npos) return {std::string(trimmed(*field))};
  const std::string& format = parts[0];
  const auto first = integer(parts[1]), last = integer(parts[2]), step = integer(parts[3]);
  const auto percent = format.find('%'), conversion = format.find_first_not_of("0123456789", percent + 1);
  if (!first || !last || !step || *step == 0 || conversion == std::string::npos ||
      (format[conversion] != 'd' && format[conversion] != 'u') || format.find('%', conversion) != std::string::npos)
    fields.refuse("data file", "FORMAT MIN MAX STEP with one %d");
  const std::string flags = format.substr(percent + 1, conversion - percent - 1);
  const auto width = static_cast<std::size_t>(std::min<std::int64_t>(integer(flags).value_or(0), 20));
  std::vector<std::string> files;
  for (std::int64_t i = *first; *step > 0 ? i <= *last : i >= *last; i += *step) {
    std::string digits = std::to_string(i);
    if (digits.size() < width) digits.insert(0, width - digits.size(), flags[0] == '0' ? '0' : ' ');
    files.push_back(format.substr(0, percent) + digits + format.substr(conversion + 1));
    if (files.size() > kMostDataFiles) fields.refuse("data file", "at most 65536 files");
  }
  if (files.empty()) fields.refuse("data file", "MIN to MAX to be at least one file");
  return files;
}

/// Decides which axes are space, which hold components and which is time. Kinds say so; if they do not, an axis without
/// direction among axes with one is a component if it is the fastest and time if it is the slowest, and a fourth plain axis is
/// time.
void assign_roles(std::vector<NrrdAxis>& axes, const HeaderFields& fields) {
  const bool directions = std::any_of(axes.begin(), axes.end(), [](const NrrdAxis& a) { return a.direction.has_value(); });
  for (std::size_t a = 0; a < axes.size(); ++a) {
    NrrdAxis& axis = axes[a];
    const std::string kind = lower(axis.kind);
    if (kind == "domain" || kind == "space")
      axis.role = NrrdRole::space;
    else if (kind == "time")
      axis.role = NrrdRole::time;
    else if (!kind.empty() && kind != "???" && kind != "none")
      axis.role = NrrdRole::component;
    else if (directions && !axis.direction)
      axis.role = a + 1 == axes.size() && a > 0 ? NrrdRole::time : NrrdRole::component;
    else
      axis.role = a == 3 ? NrrdRole::time : NrrdRole::space;
  }
  const auto count = [&](NrrdRole role) {
    return std::count_if(axes.begin(), axes.end(), [&](const NrrdAxis& a) { return a.role == role; });
  };
  if (count(NrrdRole::space) > 3 || count(NrrdRole::time) > 1)
    throw Error(ErrorCode::unsupported, fields.name() + ": " + std::to_string(count(NrrdRole::space)) + " axes of space and " +
                                            std::to_string(count(NrrdRole::time)) + " of time; expected at most three and one");
}

std::vector<NrrdAxis> parse_axes(const HeaderFields& fields) {
  const auto dimension = integer(fields.need("dimension", "1 to 16"));
  if (!dimension || *dimension < 1 || *dimension > static_cast<std::int64_t>(kMostNrrdAxes)) fields.refuse("dimension", "1 to 16");
  const auto count = static_cast<std::size_t>(*dimension);
  std::vector<NrrdAxis> axes(count);
  fields.need("sizes", std::to_string(count) + " sizes");
  const auto sizes = fields.per_axis("sizes", count);
  std::int64_t product = 1;
  for (std::size_t a = 0; a < count; ++a) {
    const auto size = integer(sizes[a]);
    if (!size || *size < 1 || __builtin_mul_overflow(product, *size, &product) || product > (std::int64_t{1} << 56))
      fields.refuse("sizes", std::to_string(count) + " positive sizes with a product that makes sense");
    axes[a].size = *size;
  }
  const auto each = [&](const std::string& field, const auto& use) {
    const auto entries = fields.per_axis(field, count);
    for (std::size_t a = 0; a < entries.size(); ++a) use(axes[a], entries[a]);
  };
  each("kinds", [](NrrdAxis& axis, const std::string& word) { axis.kind = word; });
  const std::vector<std::string> units = fields.quoted("units", count);
  for (std::size_t a = 0; a < units.size(); ++a) axes[a].unit = units[a];
  each("spacings", [&](NrrdAxis& axis, const std::string& word) { axis.spacing = fields.finite("spacings", word); });
  each("axis mins", [&](NrrdAxis& axis, const std::string& word) { axis.lower = fields.finite("axis mins", word); });
  each("axis maxs", [&](NrrdAxis& axis, const std::string& word) { axis.upper = fields.finite("axis maxs", word); });
  each("centers", [](NrrdAxis& axis, const std::string& word) { axis.cell_centered = lower(word) == "cell"; });
  if (const std::string* directions = fields.find("space directions")) {
    const auto entries = split_vectors(*directions);
    if (entries.size() != count) fields.refuse("space directions", std::to_string(count) + " vectors or none");
    for (std::size_t a = 0; a < count; ++a)
      if (lower(entries[a]) != "none") axes[a].direction = fields.vector("space directions", entries[a]);
  }
  assign_roles(axes, fields);
  return axes;
}

/// Some fields may be written in two ways.
std::string canonical(std::string field) {
  field = lower(field);
  static const std::map<std::string, std::string> kAliases{{"centerings", "centers"}, {"lineskip", "line skip"},
                                                           {"byteskip", "byte skip"}, {"datafile", "data file"},
                                                           {"axismins", "axis mins"}, {"axismaxs", "axis maxs"}};
  const auto at = kAliases.find(field);
  return at == kAliases.end() ? field : at->second;
}

}  // namespace

std::int64_t NrrdHeader::values() const {
  std::int64_t product = 1;
  for (const NrrdAxis& axis : axes) product *= axis.size;
  return product;
}

NrrdHeader parse_nrrd_header(std::string_view text, const std::string& name) {
  if (text.size() < 9 || !text.starts_with("NRRD000") || text[7] < '1' || text[7] > '6' || (text[8] != '\n' && text[8] != '\r'))
    throw Error(ErrorCode::bad_data, name + ": expected 'NRRD0001' to 'NRRD0006' on its first line");
  HeaderFields fields(name);
  std::vector<std::string> list;
  bool ended = false, in_list = false;
  std::size_t at = text.find('\n');
  at = at == std::string_view::npos ? text.size() : at + 1;
  while (at < text.size() && !ended) {
    const auto newline = text.find('\n', at);
    std::string_view line = text.substr(at, newline == std::string_view::npos ? std::string_view::npos : newline - at);
    at = newline == std::string_view::npos ? text.size() : newline + 1;
    line = line.ends_with('\r') ? line.substr(0, line.size() - 1) : line;
    if (line.empty()) {
      ended = true;
    } else if (in_list) {
      list.emplace_back(trimmed(line));
      if (list.size() > kMostDataFiles) throw Error(ErrorCode::too_large, name + ": lists more than 65536 data files");
    } else if (line.front() != '#') {
      const auto colon = line.find(':');
      if (colon == std::string_view::npos || line.size() > 65536)
        throw Error(ErrorCode::bad_data, name + ": header line '" + std::string(line.substr(0, 60)) +
                                             "' is neither 'field: value', 'key:=value' nor a comment");
      if (colon + 1 < line.size() && line[colon + 1] == '=') continue;  // a key and its value: free text for others
      const std::string field = canonical(std::string(trimmed(line.substr(0, colon))));
      fields.values[field] = std::string(trimmed(line.substr(colon + 1)));
      in_list = field == "data file" && fields.values[field].starts_with("LIST");
    }
  }

  NrrdHeader header;
  header.length = at;
  if (const std::string* unit = fields.find("sample units")) header.unit = *unit;
  const std::vector<std::string> space_units = fields.quoted("space units", 3);
  std::copy(space_units.begin(), space_units.end(), header.space_units.begin());
  header.type = parse_type(fields);
  header.encoding = parse_encoding(fields);
  header.axes = parse_axes(fields);
  header.data_files = parse_data_files(fields, list);
  if (header.data_files.empty() && !ended)
    throw Error(ErrorCode::bad_data, name + ": the header does not end with an empty line, and names no data file");
  if (const std::string* origin = fields.find("space origin"); origin && lower(*origin) != "none")
    header.origin = fields.vector("space origin", *origin);
  for (const auto& [field, value] : {std::pair{"line skip", &header.line_skip}, std::pair{"byte skip", &header.byte_skip}})
    if (const std::string* given = fields.find(field)) {
      const auto parsed = integer(*given);
      if (!parsed) fields.refuse(field, "an integer");
      *value = *parsed;
    }
  if (header.line_skip < 0) fields.refuse("line skip", "0 or more");
  const bool bytes = header.encoding != NrrdEncoding::text && size_of(header.type) > 1;
  if (bytes) {
    const std::string endian = lower(fields.need("endian", "little or big, since values have more than one byte"));
    if (endian != "little" && endian != "big") fields.refuse("endian", "little or big");
    header.big_endian = endian == "big";
  }
  return header;
}

}  // namespace isostrata
