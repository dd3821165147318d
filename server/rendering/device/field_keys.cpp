#include "rendering/device/field_keys.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace isostrata {
namespace {

std::uint64_t float_key(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value == 0 ? 0.0f : value);
  return bits >> 31 ? ~bits : bits | 0x80000000u;
}

std::uint64_t double_key(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value);
  return bits >> 63 ? ~bits : bits | std::uint64_t{1} << 63;
}

double lowest_integer(const KeyFormat& format) { return format.is_signed ? -std::ldexp(1.0, 8 * format.bytes - 1) : 0.0; }

std::uint32_t high(const KeyFormat& format, std::uint64_t key) {
  return static_cast<std::uint32_t>(format.bytes == 8 ? key >> 32 : key);
}
std::uint32_t low(const KeyFormat& format, std::uint64_t key) { return format.bytes == 8 ? static_cast<std::uint32_t>(key) : 0; }

}  // namespace

KeyFormat key_format(ScalarType type) {
  switch (type) {
    case ScalarType::int8:
      return {1, true, false, false};
    case ScalarType::uint8:
      return {1, false, false, false};
    case ScalarType::int16:
      return {2, true, false, false};
    case ScalarType::uint16:
      return {2, false, false, false};
    case ScalarType::int32:
      return {4, true, false, false};
    case ScalarType::uint32:
      return {4, false, false, false};
    case ScalarType::float32:
      return {4, true, true, false};
    case ScalarType::float64:
      return {8, true, true, false};
    case ScalarType::int64:
    case ScalarType::uint64:
      return {8, true, true, true};
  }
  throw Error(ErrorCode::internal, "key_format: no scalar type has the number " + std::to_string(static_cast<int>(type)));
}

std::uint64_t key_of(const KeyFormat& format, double value) {
  if (format.is_float) return format.bytes == 4 ? float_key(static_cast<float>(value)) : double_key(value);
  return static_cast<std::uint64_t>(value - lowest_integer(format));
}

std::uint64_t first_key(const KeyFormat& format, double bound) {
  if (format.is_float && format.bytes == 8) return double_key(bound);
  if (format.is_float) {
    float value = static_cast<float>(bound);  // overflows to infinity, which is right
    if (static_cast<double>(value) < bound) value = std::nextafter(value, std::numeric_limits<float>::infinity());
    return float_key(value);
  }
  const double lowest = lowest_integer(format), past = lowest + std::ldexp(1.0, 8 * format.bytes);
  return static_cast<std::uint64_t>(std::clamp(std::ceil(bound), lowest, past) - lowest);
}

KeyedRules keyed_rules(const KeyFormat& format, const IsoRules& rules) {
  const std::uint64_t largest = format.bytes == 8 ? ~std::uint64_t{0} : ~std::uint32_t{0};
  const auto all = rules.rules();
  std::vector<std::uint32_t> order(all.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return all[a].lower < all[b].lower; });

  KeyedRules out;
  std::vector<double> bounds(rules.isovalues().size());  // of each isovalue's upper side
  std::vector<bool> begins(bounds.size());
  std::uint64_t reach = 0;
  for (const std::uint32_t i : order) {
    const IsoRule& rule = all[i];
    if (!begins[rule.upper_index]) bounds[rule.upper_index] = rule.above;
    bounds[rule.lower_index] = rule.lower;
    begins[rule.lower_index] = true;
    const std::uint64_t lower = first_key(format, rule.lower), above = first_key(format, rule.above);
    if (lower > largest || above == 0) continue;  // every value is below, or every value is above
    reach = std::max(reach, above - 1);
    out.rules.push_back({high(format, lower), low(format, lower), high(format, above - 1), low(format, above - 1),
                         high(format, reach), low(format, reach), i, 0});
  }
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    // Where every value is on the upper side this comes round to the largest number, and then none is: no edge crosses, either
    // way.
    const std::uint64_t below = first_key(format, bounds[i]) - 1;
    const auto value = std::bit_cast<std::uint64_t>(rules.isovalues()[i]);
    out.levels.push_back(
        {high(format, below), low(format, below), static_cast<std::uint32_t>(value >> 32), static_cast<std::uint32_t>(value)});
  }
  return out;
}

}  // namespace isostrata
