#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>

#include "data/files/recognise.h"
#include "import/bytes/parsed_number.h"
#include "import/bytes/swap_bytes.h"
#include "import/hdf5/hdf5_file.h"
#include "import/xdmf/xdmf_values.h"

namespace isostrata {
namespace {

using XdmfSizes = std::vector<std::size_t>;

std::string xdmf_shown(const XdmfSizes& sizes) {
  std::string out;
  for (const std::size_t size : sizes) out += (out.empty() ? "" : " x ") + std::to_string(size);
  return out.empty() ? "none" : out;
}

std::size_t xdmf_product(const XdmfSizes& sizes, const std::string& name) {
  std::int64_t all = 1;
  for (const std::size_t size : sizes) all = checked_product({all, static_cast<std::int64_t>(std::min<std::size_t>(size, std::numeric_limits<std::int64_t>::max()))}, name);
  return static_cast<std::size_t>(all);
}

/// Each word of a text, between blanks.
template <class Visit>
void for_each_word(std::string_view text, const Visit& visit) {
  constexpr std::string_view kBlanks = " \t\r\n,";
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    if (text.empty()) return;
    const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
    visit(word);
    text.remove_prefix(word.size());
  }
}

XdmfSizes xdmf_sizes(std::string_view text, const std::string& name) {
  XdmfSizes sizes;
  for_each_word(text, [&](std::string_view word) {
    const auto size = parsed_number<std::size_t>(word);
    if (!size || sizes.size() == 32) throw Error(ErrorCode::bad_data, name + ": Dimensions '" + std::string(text.substr(0, 100)) + "'; expected at most 32 whole numbers");
    sizes.push_back(*size);
  });
  return sizes;
}

/// By NumberType and Precision; float where it says nothing, as XDMF has it.
ScalarType xdmf_type(const XdmfElement& item, const std::string& name) {
  const std::string type = item.word({"NumberType", "DataType"}), precision = item.attribute("Precision");
  const bool real = type.empty() || type == "float" || type == "double", sign = type == "int" || type == "short" || type == "char" || type == "long";
  const std::string bytes = !precision.empty() ? precision : type == "char" || type == "uchar" ? "1" : type == "short" || type == "ushort" ? "2" : type == "double" || type == "long" ? "8" : "4";
  if (real && (bytes == "4" || bytes == "8")) return bytes == "4" ? ScalarType::float32 : ScalarType::float64;
  if (sign || type == "uint" || type == "uchar" || type == "ushort") {
    if (bytes == "1") return sign ? ScalarType::int8 : ScalarType::uint8;
    if (bytes == "2") return sign ? ScalarType::int16 : ScalarType::uint16;
    if (bytes == "4") return sign ? ScalarType::int32 : ScalarType::uint32;
    if (bytes == "8") return sign ? ScalarType::int64 : ScalarType::uint64;
  }
  throw Error(ErrorCode::unsupported, name + ": numbers of type '" + type + "' of " + bytes + " bytes; expected Float of 4 or 8, or Int, UInt, Char or UChar of 1 to 8");
}

template <class T>
T xdmf_number(std::string_view word, const std::string& name) {
  const std::string_view plain = word.starts_with('+') ? word.substr(1) : word;
  if (const auto value = parsed_number<T>(plain)) return *value;
  if constexpr (std::is_integral_v<T>)  // "3.0", as some write ids
    if (const auto value = parsed_number<double>(plain); value && *value == static_cast<double>(static_cast<std::int32_t>(std::clamp(*value, -2147483648.0, 2147483647.0))))
      return static_cast<T>(*value);
  throw Error(ErrorCode::bad_data, name + ": '" + std::string(word.substr(0, 40)) + "' is not a number of its type");
}

const char* nothing_there(const XdmfElement& item) { return item.text().empty() ? "; its text is empty" : ""; }

}  // namespace

std::vector<std::int64_t> XdmfArray::whole() const {
  std::vector<std::int64_t> out(count());
  std::visit([&](auto span) {
    using T = typename decltype(span)::value_type;
    std::transform(span.begin(), span.end(), out.begin(), [](T value) {
      if constexpr (std::is_floating_point_v<T>)
        return value >= T(-9e18) && value <= T(9e18) ? static_cast<std::int64_t>(value) : std::int64_t{-1};
      else
        return static_cast<std::int64_t>(value);
    });
  }, scalar_span(type, values));
  return out;
}

std::vector<double> XdmfArray::real() const {
  std::vector<double> out(count());
  std::visit([&](auto span) { std::transform(span.begin(), span.end(), out.begin(), [](auto value) { return static_cast<double>(value); }); }, scalar_span(type, values));
  return out;
}

XdmfValues::XdmfValues(const ReadRequest& request, XdmfFile& file) : request_(request), file_(file) {}
XdmfValues::~XdmfValues() = default;

const Hdf5File& XdmfValues::hdf(const std::filesystem::path& file) {
  constexpr std::size_t kMostOpen = 64;
  auto known = open_.find(file);
  if (known == open_.end()) {
    if (open_.size() == kMostOpen) open_.clear();
    known = open_.emplace(file, std::make_unique<Hdf5File>(file, Hdf5Walk::none)).first;
  }
  return *known->second;
}

XdmfArray XdmfValues::room(ScalarType type, XdmfSizes shape, std::span<std::byte>& to, const std::string& name) {
  const auto bytes = static_cast<std::uint64_t>(checked_product({static_cast<std::int64_t>(xdmf_product(shape, name)), static_cast<std::int64_t>(size_of(type))}, name));
  check_bytes(request_, bytes_ += bytes, name);
  auto [storage, all] = allocate<std::byte>(static_cast<std::size_t>(bytes));
  to = all;
  return {type, std::move(shape), all, storage};
}

XdmfArray XdmfValues::read(const XdmfElement& item) {
  constexpr int kDeepest = 16;
  const std::string name = item.file->filename().string(), kind = item.word({"ItemType", "Type"});
  if (depth_ >= kDeepest) throw Error(ErrorCode::bad_data, name + ": DataItems within DataItems, more than " + std::to_string(kDeepest) + " deep");
  ++depth_;
  XdmfArray out = [&] {
    if (kind.empty() || kind == "uniform") return uniform(item, nullptr);
    if (kind == "hyperslab") return slab(item);
    if (kind == "function") return joined(item);
    throw Error(ErrorCode::unsupported, name + ": a DataItem of ItemType '" + kind + "'; expected Uniform, HyperSlab or Function");
  }();
  --depth_;
  return out;
}

XdmfArray XdmfValues::uniform(const XdmfElement& item, const Slab* slab) {
  const std::string name = item.file->filename().string(), format = item.word({"Format"});
  const XdmfSizes declared = xdmf_sizes(item.attribute("Dimensions"), name);
  if (format == "hdf" || format == "hdf5" || format == "h5") return of_hdf(item, declared, slab);
  if (!format.empty() && format != "xml" && format != "binary") throw Error(ErrorCode::unsupported, name + ": a DataItem of Format '" + format + "'; expected XML, HDF or Binary");
  const XdmfArray all = format == "binary" ? of_binary(item, declared) : of_text(item, declared);
  return slab ? taken(all, *slab, name) : all;
}

// "run.h5:/group/array", or with what is taken of it behind: "run.h5:/array|0 0|1 1|5 3|10 3" (start, stride, count, sizes).
XdmfArray XdmfValues::of_hdf(const XdmfElement& item, const XdmfSizes& declared, const Slab* slab) {
  const std::string name = item.file->filename().string();
  std::vector<std::string_view> parts;
  for (std::string_view rest = item.text();;) {
    const auto bar = rest.find('|');
    parts.push_back(rest.substr(0, bar));
    if (bar == std::string_view::npos) break;
    rest.remove_prefix(bar + 1);
  }
  const auto colon = parts.front().find(':');
  if (colon == std::string_view::npos || (parts.size() > 1 && parts.size() < 4))
    throw Error(ErrorCode::bad_data, name + ": a DataItem of HDF5 says '" + std::string(item.text().substr(0, 200)) + "'; expected FILE.h5:/ARRAY");
  const std::string path(parts.front().substr(colon + 1));
  const Hdf5File& file = hdf(referred_file(*item.file, std::string(parts.front().substr(0, colon))));
  const auto array = file.find(path);
  if (!array) throw Error(ErrorCode::bad_data, name + ": refers to '" + std::string(parts.front().substr(0, 200)) + "', which is not an array of numbers");
  Slab own;
  if (parts.size() >= 4) {
    own = {xdmf_sizes(parts[1], name), xdmf_sizes(parts[2], name), xdmf_sizes(parts[3], name)};
    if (!slab) slab = &own;
  }
  const XdmfSizes& there = array->shape;
  Slab all{XdmfSizes(there.size(), 0), XdmfSizes(there.size(), 1), there};
  if (slab) {
    if (slab->from.size() != there.size() || slab->stride.size() != there.size() || slab->count.size() != there.size())
      throw Error(ErrorCode::bad_data, name + ": takes a part along " + std::to_string(slab->count.size()) + " axes of '" + path + "', which has " + xdmf_shown(there));
    all = *slab;
  } else if (!declared.empty() && xdmf_product(declared, name) != array->values()) {
    // Fewer along some axis: the first ones.
    const bool fits = declared.size() == there.size() && std::equal(declared.begin(), declared.end(), there.begin(), std::less_equal<>());
    if (!fits) throw Error(ErrorCode::bad_data, name + ": '" + path + "' has " + xdmf_shown(there) + " values; the file says " + xdmf_shown(declared));
    all.count = declared;
  }
  // The box around what is taken, and of that the places of the stride.
  XdmfSizes box = all.count;
  for (std::size_t a = 0; a < there.size(); ++a) {
    std::size_t last = 0;
    if (all.count[a] == 0 || all.stride[a] == 0 || __builtin_mul_overflow(all.count[a] - 1, all.stride[a], &last) || __builtin_add_overflow(last, all.from[a], &last) || last >= there[a])
      throw Error(ErrorCode::bad_data, name + ": takes " + std::to_string(all.count[a]) + " places from " + std::to_string(all.from[a]) + " by " + std::to_string(all.stride[a]) + " of axis " + std::to_string(a) +
                                           " of '" + path + "', which has " + xdmf_shown(there));
    box[a] = last - all.from[a] + 1;
  }
  std::span<std::byte> to;
  XdmfArray out = room(array->type, box, to, name);
  file.read(*array, all.from, box, to);
  if (box != all.count) out = taken(out, {XdmfSizes(there.size(), 0), all.stride, all.count}, name);
  if (!slab && !declared.empty() && xdmf_product(declared, name) == out.count()) out.shape = declared;
  return out;
}

XdmfArray XdmfValues::of_binary(const XdmfElement& item, const XdmfSizes& declared) {
  const std::string name = item.file->filename().string(), file_name(item.text()), endian = item.word({"Endian"}), packed = item.word({"Compression"}), seek = item.attribute("Seek");
  if (!packed.empty() && packed != "raw") throw Error(ErrorCode::unsupported, name + ": a DataItem of Compression '" + packed + "'; expected Raw");
  const auto begin = seek.empty() ? std::optional<std::size_t>(0) : parsed_number<std::size_t>(seek);
  if (!begin) throw Error(ErrorCode::bad_data, name + ": Seek '" + seek + "' is not a whole number");
  if (declared.empty()) throw Error(ErrorCode::bad_data, name + ": a DataItem of Format Binary without Dimensions");
  const ScalarType type = xdmf_type(item, name);
  const std::size_t width = size_of(type);
  const auto bytes = static_cast<std::size_t>(checked_product({static_cast<std::int64_t>(xdmf_product(declared, name)), static_cast<std::int64_t>(width)}, name));
  const auto file = std::make_shared<const MappedFile>(referred_file(*item.file, file_name));
  const std::size_t there = file->bytes().size();
  if (*begin > there || bytes > there - *begin)
    throw Error(ErrorCode::bad_data, name + ": " + xdmf_shown(declared) + " numbers of " + std::to_string(width) + " bytes declared from byte " + std::to_string(*begin) + " of '" + file_name + "', which has " + std::to_string(there));
  const std::span<const std::byte> from = file->bytes().subspan(*begin, bytes);
  const bool swap = width > 1 && (endian == "big") == (std::endian::native == std::endian::little) && (endian == "big" || endian == "little");
  if (!swap && *begin % width == 0) return {type, declared, from, file};
  std::span<std::byte> to;
  XdmfArray out = room(type, declared, to, name);
  std::memcpy(to.data(), from.data(), bytes);
  if (swap) swap_bytes(to, width);
  return out;
}

XdmfArray XdmfValues::of_text(const XdmfElement& item, XdmfSizes declared) {
  const std::string name = item.file->filename().string();
  std::size_t words = 0;
  for_each_word(item.text(), [&](std::string_view) { ++words; });
  if (declared.empty()) declared = {words};
  if (xdmf_product(declared, name) != words) throw Error(ErrorCode::bad_data, name + ": " + xdmf_shown(declared) + " numbers declared, " + std::to_string(words) + " present" + nothing_there(item));
  std::span<std::byte> to;
  XdmfArray out = room(xdmf_type(item, name), declared, to, name);
  std::visit([&](auto span) {
    using T = typename decltype(span)::value_type;
    std::size_t at = 0;
    for_each_word(item.text(), [&](std::string_view word) {
      const T value = xdmf_number<T>(word, name);
      std::memcpy(to.data() + at, &value, sizeof value);
      at += sizeof value;
    });
  }, scalar_span(out.type, out.values));
  return out;
}

// The first DataItem says start, stride and count, the second one of what.
XdmfArray XdmfValues::slab(const XdmfElement& item) {
  const std::string name = item.file->filename().string();
  const std::vector<XdmfElement> items = file_.children(item, "DataItem");
  if (items.size() != 2) throw Error(ErrorCode::bad_data, name + ": a HyperSlab of " + std::to_string(items.size()) + " DataItems; expected two, the part and the whole");
  const std::vector<std::int64_t> says = read(items[0]).whole();
  if (says.empty() || says.size() % 3 != 0 || std::any_of(says.begin(), says.end(), [](std::int64_t one) { return one < 0; }))
    throw Error(ErrorCode::bad_data, name + ": a HyperSlab of " + std::to_string(says.size()) + " numbers; expected a start, a stride and a count of each axis, none of them negative");
  const auto part = [&](std::size_t which) {
    const auto begin = says.begin() + static_cast<std::ptrdiff_t>(which * says.size() / 3);
    return XdmfSizes(begin, begin + static_cast<std::ptrdiff_t>(says.size() / 3));
  };
  const Slab wanted{part(0), part(1), part(2)};
  const std::string kind = items[1].word({"ItemType", "Type"});
  XdmfArray out = kind.empty() || kind == "uniform" ? uniform(items[1], &wanted) : taken(read(items[1]), wanted, name);
  const XdmfSizes declared = xdmf_sizes(item.attribute("Dimensions"), name);
  if (!declared.empty() && xdmf_product(declared, name) == out.count()) out.shape = declared;
  return out;
}

XdmfArray XdmfValues::taken(const XdmfArray& from, const Slab& slab, const std::string& name) {
  const std::size_t axes = from.shape.size(), width = size_of(from.type);
  if (slab.from.size() != axes || slab.count.size() != axes || slab.stride.size() != axes)
    throw Error(ErrorCode::bad_data, name + ": takes a part along " + std::to_string(slab.count.size()) + " axes of " + xdmf_shown(from.shape) + " values");
  for (std::size_t a = 0; a < axes; ++a)
    if (slab.count[a] == 0 || slab.stride[a] == 0 || slab.from[a] >= from.shape[a] || (slab.count[a] - 1) > (from.shape[a] - 1 - slab.from[a]) / slab.stride[a])
      throw Error(ErrorCode::bad_data, name + ": takes " + std::to_string(slab.count[a]) + " places from " + std::to_string(slab.from[a]) + " by " + std::to_string(slab.stride[a]) + " along axis " + std::to_string(a) + " of " +
                                           xdmf_shown(from.shape) + " values");
  std::span<std::byte> to;
  XdmfArray out = room(from.type, slab.count, to, name);
  XdmfSizes at(axes, 0);
  for (std::size_t n = 0; n < out.count(); ++n) {
    std::size_t place = 0;
    for (std::size_t a = 0; a < axes; ++a) place = place * from.shape[a] + slab.from[a] + at[a] * slab.stride[a];
    std::memcpy(to.data() + n * width, from.values.data() + place * width, width);
    for (std::size_t a = axes; a-- > 0 && ++at[a] == slab.count[a];) at[a] = 0;
  }
  return out;
}

// JOIN($0, $1, $2): one value of each after the other. Other functions compute, which is the task of the program that wrote the file.
XdmfArray XdmfValues::joined(const XdmfElement& item) {
  const std::string name = item.file->filename().string(), function = item.attribute("Function");
  std::string plain = small_letters(function);
  std::erase_if(plain, [](unsigned char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; });
  std::replace(plain.begin(), plain.end(), ';', ',');
  const std::vector<XdmfElement> items = file_.children(item, "DataItem");
  std::string expected;
  for (std::size_t i = 0; i < items.size(); ++i) expected += (i ? ",$" : "$") + std::to_string(i);
  if (plain == "$0" && items.size() == 1) return read(items[0]);
  if (plain != "join(" + expected + ")" || items.empty())
    throw Error(ErrorCode::unsupported, name + ": the function '" + function.substr(0, 100) + "' of " + std::to_string(items.size()) + " DataItems; expected JOIN of all of them; save its values as an array");
  std::vector<XdmfArray> parts;
  for (const XdmfElement& one : items) parts.push_back(read(one));
  const std::size_t width = size_of(parts.front().type), count = parts.front().count();
  for (const XdmfArray& part : parts)
    if (part.type != parts.front().type || part.count() != count)
      throw Error(ErrorCode::bad_data, name + ": joins " + xdmf_shown(parts.front().shape) + " and " + xdmf_shown(part.shape) + " values; expected as many, of one type");
  XdmfSizes shape = parts.front().shape;
  shape.push_back(parts.size());
  std::span<std::byte> to;
  XdmfArray out = room(parts.front().type, std::move(shape), to, name);
  for (std::size_t n = 0; n < count; ++n)
    for (std::size_t p = 0; p < parts.size(); ++p) std::memcpy(to.data() + (n * parts.size() + p) * width, parts[p].values.data() + n * width, width);
  return out;
}

}  // namespace isostrata
