// Arrays of scalars in their own type, mapped or owned, read-only once made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "base/error.h"

namespace isostrata {

enum class ScalarType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

const char* to_string(ScalarType type);  // "float32", ...
std::size_t size_of(ScalarType type);    // bytes

/// A view of n scalars in one of the ten types. visit(array, [](auto values) { ... }) gets a std::span<const T>.
using ScalarSpan =
    std::variant<std::span<const std::int8_t>, std::span<const std::uint8_t>, std::span<const std::int16_t>,
                 std::span<const std::uint16_t>, std::span<const std::int32_t>, std::span<const std::uint32_t>,
                 std::span<const std::int64_t>, std::span<const std::uint64_t>, std::span<const float>, std::span<const double>>;

/// bytes.size() must be a multiple of size_of(type) and bytes.data() aligned to it.
ScalarSpan scalar_span(ScalarType type, std::span<const std::byte> bytes);

enum class Association {
  point,         // stored at the points of the file
  cell_averaged  // stored per cell in the file; averaged to points on import (each point: mean over the cells that use it)
};

/// One scalar per cell, as the file has them: cells without interpolation (whole_values.h).
struct CellValues {
  ScalarType type = ScalarType::float32;
  ScalarSpan values;                    // [nc]; of the pieces of a cell that was split: that cell's
  double lower = 0, upper = 0;          // range of the finite values; lower > upper if there is none
  std::int64_t nan_count = 0;           // values that are NaN or infinite
  std::shared_ptr<const void> storage;  // keeps values alive
};

/// One scalar per point. Vectors arrive as several arrays: NAME (magnitude), NAME_x, NAME_y, NAME_z (NAME_0, NAME_1, ... beyond
/// three).
struct PointArray {
  std::string name;
  Association association = Association::point;
  int components = 1;          // of the array in the file: 3 for the magnitude of a vector and for each of its components
  std::string component = "";  // "" for a scalar, "magnitude", or the component's name ("x", "0", ...)
  std::string unit = "";       // as the file says it: "K", "m s-1"; "" if it says none
  ScalarType type = ScalarType::float32;
  ScalarSpan values;                    // [np]
  double lower = 0, upper = 0;          // range of the finite values; lower > upper if there is none
  std::int64_t nan_count = 0;           // values that are NaN or infinite
  std::shared_ptr<const void> storage;  // keeps values alive
  std::shared_ptr<const CellValues> cells;  // of cell_averaged: what was averaged; null also in a part of a grid whose cells are other ones

  double at(std::size_t point) const {
    return std::visit([&](auto v) { return static_cast<double>(v[point]); }, values);
  }
};

/// "temperature (K)"; the name alone if there is no unit.
std::string name_with_unit(const std::string& name, const std::string& unit);

/// The values of cells as an array of so many points, for whoever counts values.
PointArray as_array(const CellValues& cells, const std::string& name);

/// Sets lower, upper and nan_count from values: one parallel pass, the same result for any number of threads.
void measure_range(PointArray& array);
void measure_range(CellValues& cells);

}  // namespace isostrata
