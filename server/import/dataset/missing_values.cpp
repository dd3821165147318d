#include "import/dataset/missing_values.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace isostrata {
namespace {

constexpr std::size_t kSamples = 1u << 16;
constexpr std::size_t kFew = 32;  // so many values, or fewer, may be names of materials

/// How many spans of the others such a value has to lie apart from them; nothing if it is not customary.
template <class T>
std::optional<double> customary(T value) {
  if constexpr (std::is_signed_v<T> && std::is_integral_v<T> && sizeof(T) > 1)
    if (value == std::numeric_limits<T>::min()) return 1;
  const auto number = static_cast<double>(value);
  if (std::is_integral_v<T> && number >= 0) return std::nullopt;  // 9999 may be a number like others
  for (const double nines : {9999.0, 99999.0, 999999.0, 9999999.0})
    if (std::abs(number) == nines) return 1;
  if (number == -999 || number == -999.25) return 1;  // 999 may be the density of water beside air
  if constexpr (std::is_floating_point_v<T>) {
    const T size = std::abs(value);
    if (size == static_cast<T>(std::numeric_limits<float>::max()) || size == std::numeric_limits<T>::max()) return 1000;
    for (const double power : {1e15, 1e20, 1e25, 1e30, 1e31, 1e32, 1e33, 1e34, 1e35, 1e36, 9.9692099683868690e36, 1e37, 1e38})
      if (size == static_cast<T>(power) || size == static_cast<T>(static_cast<float>(power))) return 1000;
  }
  return std::nullopt;
}

template <class T>
T value_at(std::span<const std::byte> bytes, std::size_t i) {
  T value;
  std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
  return value;
}

bool is_value(double value) { return std::isfinite(value); }

/// All of an array's values but one.
struct Others {
  double lower = std::numeric_limits<double>::infinity(), upper = -lower;
  std::int64_t left_out = 0;

  bool apart_from(double value, double spans) const {
    if (!(lower < upper)) return false;
    return (value > upper ? value - upper : lower - value) >= spans * (upper - lower);
  }
};

template <class T>
Others others_than(T value, const std::vector<FileArray*>& arrays) {
  Others out;
  for (const FileArray* array : arrays)
    for (std::size_t i = 0; i < array->values.size() / sizeof(T); ++i) {
      const T at = value_at<T>(array->values, i);
      if (at == value) {
        ++out.left_out;
      } else if (is_value(static_cast<double>(at))) {
        out.lower = std::min(out.lower, static_cast<double>(at));
        out.upper = std::max(out.upper, static_cast<double>(at));
      }
    }
  return out;
}

/// Some of the values, each once, in their order.
template <class T>
std::vector<T> sample_of(const std::vector<FileArray*>& arrays) {
  std::size_t all = 0, at = 0;
  for (const FileArray* array : arrays) all += array->values.size() / sizeof(T);
  const std::size_t stride = all / kSamples + 1;
  std::vector<T> out;
  for (const FileArray* array : arrays) {
    const std::size_t count = array->values.size() / sizeof(T);
    for (; at < count; at += stride)
      if (const T value = value_at<T>(array->values, at); is_value(static_cast<double>(value))) out.push_back(value);
    at -= count;
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

template <class To, class T>
void replace(T value, FileArray& array) {
  const std::size_t count = array.values.size() / sizeof(T);
  auto [storage, to] = allocate<To>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const T at = value_at<T>(array.values, i);
    to[i] = at == value ? std::numeric_limits<To>::quiet_NaN() : static_cast<To>(at);
  }
  array.type = std::is_same_v<To, float> ? ScalarType::float32 : ScalarType::float64;
  array.values = std::as_bytes(std::span<const To>(to));
  array.storage = storage;
}

template <class T>
void leave_out(const std::vector<FileArray*>& arrays, const ReadRequest& request, std::vector<std::string>& notes) {
  using To = std::conditional_t<std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) < 4), float, double>;
  const std::vector<T> sample = sample_of<T>(arrays);
  if (sample.size() <= kFew) return;
  for (const bool highest : {false, true}) {
    const T value = highest ? sample.back() : sample.front();
    const auto spans = customary(value);
    const Others some{static_cast<double>(highest ? sample.front() : sample[1]), static_cast<double>(highest ? sample[sample.size() - 2] : sample.back())};
    if (!spans || !some.apart_from(static_cast<double>(value), *spans)) continue;
    const Others others = others_than(value, arrays);
    if (others.left_out < 2 || !others.apart_from(static_cast<double>(value), *spans)) continue;
    std::uint64_t bytes = 0;
    for (const FileArray* array : arrays) bytes += array->values.size() / sizeof(T) * sizeof(To);
    std::ostringstream note;
    note << "array '" << arrays.front()->name << "': " << static_cast<double>(value) << " at " << others.left_out << " places is taken for no value: it lies far from all others, "
         << others.lower << " to " << others.upper;
    if (bytes > request.max_bytes / 2) {
      notes.push_back("array '" + arrays.front()->name + "': its " + (highest ? "highest" : "lowest") + " value may stand for no value; it is kept, as there is no room to change the array");
      return;
    }
    for (FileArray* array : arrays) replace<To>(value, *array);
    notes.push_back(note.str());
    return;  // of both ends, one
  }
}

}  // namespace

void leave_out_missing(Imported& imported, const ReadRequest& request) {
  std::vector<std::pair<const FileArray*, std::vector<FileArray*>>> groups;  // of one name, type and association
  for (Block& block : imported.blocks)
    for (FileArray& array : block.arrays) {
      auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& of) {
        return of.first->name == array.name && of.first->type == array.type && of.first->on_cells == array.on_cells && of.first->components == array.components;
      });
      if (group == groups.end()) group = groups.insert(group, {&array, {}});
      group->second.push_back(&array);
    }
  for (auto& [first, arrays] : groups)
    std::visit([&](auto like) { leave_out<std::remove_cvref_t<decltype(like[0])>>(arrays, request, imported.notes); }, scalar_span(first->type, {}));
}

void leave_out_value(FileArray& array, double none) {
  std::visit(
      [&](auto like) {
        using T = std::remove_cvref_t<decltype(like[0])>;
        using To = std::conditional_t<std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) < 4), float, double>;
        if constexpr (std::is_integral_v<T>)
          if (none != std::floor(none) || none < static_cast<double>(std::numeric_limits<T>::lowest()) || none >= std::ldexp(1.0, std::numeric_limits<T>::digits)) return;
        const auto value = static_cast<T>(none);
        bool any = false;
        for (std::size_t i = 0; i < array.values.size() / sizeof(T) && !any; ++i) any = value_at<T>(array.values, i) == value;
        if (any) replace<To>(value, array);
      },
      scalar_span(array.type, {}));
}

}  // namespace isostrata
