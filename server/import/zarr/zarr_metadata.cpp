#include "import/zarr/zarr_metadata.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "import/bytes/half_number.h"
#include "import/zarr/zarr_json.h"

namespace isostrata {
namespace {

namespace json = boost::json;

constexpr std::size_t kMostAxes = 16;

/// Bits as version 3 writes numbers that JSON has not: "0x7fc00000".
bool take_bits(const ZarrArray& array, std::string_view text, std::array<std::byte, 8>& fill) {
  std::uint64_t bits = 0;
  if (!text.starts_with("0x") || text.size() != 2 + 2 * array.stored_width()) return false;
  const auto [end, error] = std::from_chars(text.data() + 2, text.data() + text.size(), bits, 16);
  if (error != std::errc{} || end != text.data() + text.size()) return false;
  if (array.half) {
    const float value = half_number(static_cast<std::uint16_t>(bits));
    std::memcpy(fill.data(), &value, sizeof value);
    return true;
  }
  std::memcpy(fill.data(), &bits, sizeof bits);  // little-endian, as every machine that this is built for
  return true;
}

/// "<u2" as the type and order of bytes of what the array's chunks hold; nothing if it is none.
std::optional<ZarrArray> stored_as(const ZarrArray& array, const std::string& type) {
  if (type.size() < 2 || std::string_view("<>|=").find(type[0]) == std::string_view::npos) return std::nullopt;
  ZarrArray other = array;
  take_zarr_type(other, std::string_view(type).substr(1));
  other.swap = type[0] == '>' && other.stored_width() > 1;
  return other;
}

/// Whether a filter's settings say that it takes and makes numbers as the chunks have them.
void check_own_type(const ZarrArray& array, std::string_view id, const json::object& settings) {
  const std::string from = text_in(settings, "dtype"), to = text_in(settings, "astype");
  const auto own = [&](const std::string& type) {
    const auto other = stored_as(array, type);
    return other && other->stored == array.stored && other->half == array.half && other->swap == array.swap;
  };
  if (!own(from) || (!to.empty() && !own(to)))
    unsupported(array, "the filter '" + std::string(id) + "' makes '" + (to.empty() ? from : to).substr(0, 20) + "' of '" + from.substr(0, 20) + "'; expected the array's own type");
}

void take_fixed_scale_offset(ZarrArray& array, const json::object& settings) {
  const std::string to = text_in(settings, "astype");
  const auto stored = stored_as(array, to);
  const json::value *scale = member(settings, "scale"), *offset = member(settings, "offset");
  const bool real = array.type == ScalarType::float32 || array.type == ScalarType::float64;
  if (!real || array.half || array.delta || array.packing || !stored || stored->half || stored->type == ScalarType::float32 || stored->type == ScalarType::float64)
    unsupported(array, "the filter 'fixedscaleoffset' makes '" + to.substr(0, 20) + "'; expected whole numbers of real ones of 4 or 8 bytes");
  if (!scale || !scale->is_number() || !offset || !offset->is_number() || !(std::abs(scale->to_number<double>()) > 0))
    bad(array, "the filter 'fixedscaleoffset' has no 'scale' other than 0 and 'offset'");
  array.stored = stored->stored;
  array.swap = stored->swap;
  array.packing = ZarrPacking{scale->to_number<double>(), offset->to_number<double>(), true};
}

}  // namespace

std::vector<std::int64_t> zarr_sizes(const ZarrArray& array, const json::object& of, const char* name) {
  const json::array* list = array_in(of, name);
  if (!list || list->empty() || list->size() > kMostAxes) bad(array, std::string("expected '") + name + "', a list of 1 to 16 whole numbers");
  std::vector<std::int64_t> out;
  for (const json::value& size : *list) {
    if (!size.is_int64() || size.get_int64() < 1) bad(array, std::string("'") + name + "' has " + shown(size) + "; expected whole numbers of at least 1");
    out.push_back(size.get_int64());
  }
  return out;
}

void take_zarr_type(ZarrArray& array, std::string_view name) {
  static constexpr std::pair<std::string_view, ScalarType> kTypes[] = {
      {"b1 bool", ScalarType::uint8},   {"u1 uint8", ScalarType::uint8},   {"i1 int8", ScalarType::int8},   {"u2 uint16", ScalarType::uint16},   {"i2 int16", ScalarType::int16},
      {"u4 uint32", ScalarType::uint32}, {"i4 int32", ScalarType::int32}, {"u8 uint64", ScalarType::uint64}, {"i8 int64", ScalarType::int64},
      {"f4 float32", ScalarType::float32}, {"f8 float64", ScalarType::float64}};
  for (const auto& [names, type] : kTypes)
    if (!name.empty() && (name == names.substr(0, 2) || name == names.substr(3))) {
      array.type = array.stored = type;
      array.half = false;
      return;
    }
  if (name == "f2" || name == "float16") {
    array.type = array.stored = ScalarType::float32;
    array.half = true;
    return;
  }
  unsupported(array, "an array of type '" + std::string(name.substr(0, 40)) + "'; expected whole or real numbers of 1, 2, 4 or 8 bytes, or bool");
}

bool take_zarr_filter(ZarrArray& array, std::string_view id, const json::object& settings) {
  if (id == "fixedscaleoffset") {
    take_fixed_scale_offset(array, settings);
  } else if (id == "delta" && !array.delta && !array.half) {
    check_own_type(array, id, settings);
    array.delta = true;
  } else if (id == "quantize" && !array.packing) {
    check_own_type(array, id, settings);
  } else {
    return id == "bitround";
  }
  return true;
}

void take_zarr_fill(ZarrArray& array, const json::value* value) {
  if (!value) return;
  const std::string_view text = value->is_string() ? std::string_view(value->get_string()) : std::string_view();
  const bool real = array.type == ScalarType::float32 || array.type == ScalarType::float64;
  if (real && take_bits(array, text, array.fill)) return;
  const double infinite = std::numeric_limits<double>::infinity();
  double number = 0;
  bool known = true;
  if (value->is_bool()) number = value->get_bool();
  else if (value->is_number()) number = value->to_number<double>();
  else if (real && (text == "NaN" || text == "Infinity" || text == "-Infinity")) number = text == "NaN" ? std::nan("") : text == "Infinity" ? infinite : -infinite;
  else known = false;
  std::visit(
      [&](auto of) {
        using T = std::remove_const_t<typename decltype(of)::value_type>;
        T one{};
        if constexpr (std::is_floating_point_v<T>) {
          one = static_cast<T>(number);
        } else if (known && value->is_int64()) {
          known = std::in_range<T>(value->get_int64());
          one = static_cast<T>(value->get_int64());
        } else if (known && value->is_uint64()) {
          known = std::in_range<T>(value->get_uint64());
          one = static_cast<T>(value->get_uint64());
        } else if (known) {
          known = number == std::floor(number) && std::abs(number) < 0x1p53 && std::in_range<T>(static_cast<std::int64_t>(number));
          if (known) one = static_cast<T>(number);
        }
        std::memcpy(array.fill.data(), &one, sizeof one);
      },
      scalar_span(array.type, {}));
  if (!known) bad(array, "'fill_value' is " + shown(*value) + "; expected a value of the array's type");
}

}  // namespace isostrata
