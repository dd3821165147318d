#include "data/values/array.h"

#include <mutex>

#include "base/parallel.h"
#include "data/values/finite_values.h"

namespace isostrata {
namespace {

template <class T>
ScalarSpan typed(std::span<const std::byte> bytes) {
  return std::span<const T>(reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T));
}

}  // namespace

const char* to_string(ScalarType type) {
  switch (type) {
    case ScalarType::int8:
      return "int8";
    case ScalarType::uint8:
      return "uint8";
    case ScalarType::int16:
      return "int16";
    case ScalarType::uint16:
      return "uint16";
    case ScalarType::int32:
      return "int32";
    case ScalarType::uint32:
      return "uint32";
    case ScalarType::int64:
      return "int64";
    case ScalarType::uint64:
      return "uint64";
    case ScalarType::float32:
      return "float32";
    case ScalarType::float64:
      return "float64";
  }
  return "unknown";
}

std::size_t size_of(ScalarType type) {
  switch (type) {
    case ScalarType::int8:
    case ScalarType::uint8:
      return 1;
    case ScalarType::int16:
    case ScalarType::uint16:
      return 2;
    case ScalarType::int32:
    case ScalarType::uint32:
    case ScalarType::float32:
      return 4;
    case ScalarType::int64:
    case ScalarType::uint64:
    case ScalarType::float64:
      return 8;
  }
  return 0;
}

ScalarSpan scalar_span(ScalarType type, std::span<const std::byte> bytes) {
  const std::size_t size = size_of(type);
  if (size == 0 || bytes.size() % size != 0 || reinterpret_cast<std::uintptr_t>(bytes.data()) % size != 0)
    throw Error(ErrorCode::internal, "scalar_span: " + std::to_string(bytes.size()) +
                                         " bytes do not hold whole, aligned values of " + to_string(type));
  switch (type) {
    case ScalarType::int8:
      return typed<std::int8_t>(bytes);
    case ScalarType::uint8:
      return typed<std::uint8_t>(bytes);
    case ScalarType::int16:
      return typed<std::int16_t>(bytes);
    case ScalarType::uint16:
      return typed<std::uint16_t>(bytes);
    case ScalarType::int32:
      return typed<std::int32_t>(bytes);
    case ScalarType::uint32:
      return typed<std::uint32_t>(bytes);
    case ScalarType::int64:
      return typed<std::int64_t>(bytes);
    case ScalarType::uint64:
      return typed<std::uint64_t>(bytes);
    case ScalarType::float32:
      return typed<float>(bytes);
    case ScalarType::float64:
      break;
  }
  return typed<double>(bytes);
}

namespace {

template <class Values>
void measure(Values& array) {
  FiniteValues total;
  std::mutex mutex;
  std::visit(
      [&](auto values) {
        using T = typename decltype(values)::value_type;
        const auto measure = finite_values_of<T>();
        parallel_for(static_cast<std::int64_t>(values.size()), 1 << 18, [&](std::int64_t begin, std::int64_t end) {
          const FiniteValues part = measure(values.data() + begin, static_cast<std::size_t>(end - begin));
          std::lock_guard lock(mutex);
          total.merge(part);  // minimum, maximum and integer sum: the order of the parts does not matter
        });
      },
      array.values);
  array.lower = total.lower;
  array.upper = total.upper;
  array.nan_count = total.not_finite;
}

}  // namespace

std::string name_with_unit(const std::string& name, const std::string& unit) { return unit.empty() ? name : name + " (" + unit + ")"; }

PointArray as_array(const CellValues& cells, const std::string& name) {
  PointArray array;
  array.name = name;
  array.type = cells.type;
  array.values = cells.values;
  array.lower = cells.lower;
  array.upper = cells.upper;
  array.nan_count = cells.nan_count;
  array.storage = cells.storage;
  return array;
}

void measure_range(PointArray& array) { measure(array); }
void measure_range(CellValues& cells) { measure(cells); }

}  // namespace isostrata
