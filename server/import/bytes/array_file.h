// A file that is a container of arrays by name.
#pragma once

#include <cstddef>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "data/values/array.h"

namespace isostrata {

struct StoredArray {
  std::string name;  // with its groups: "run/density"
  std::string path;  // in the file
  ScalarType type = ScalarType::float32;
  std::vector<std::size_t> shape;
  bool packed = false;  // it says that other values are meant than those that are stored
  bool placed = false;  // its axes refer to others by netCDF's way

  std::size_t values() const { return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>()); }
};

class ArrayFile {
 public:
  virtual ~ArrayFile() = default;
  const std::vector<StoredArray>& arrays() const { return arrays_; }
  /// Part of one along each of its axes, in the machine's byte order. Throws bad_data.
  virtual void read(const StoredArray& array, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count, std::span<std::byte> to) const = 0;
  /// The unit of its values; empty if it says none.
  virtual std::string unit(const StoredArray&) const { return {}; }
  /// How far apart its places are along each axis, in micrometres, as Fiji and ilastik say it; empty if it does not.
  virtual std::vector<double> micrometres(const StoredArray&) const { return {}; }
  /// How many places along an axis lie together; 1 if it is not in chunks.
  virtual std::size_t chunk(const StoredArray& array, std::size_t axis) const = 0;

 protected:
  std::vector<StoredArray> arrays_;
};

}  // namespace isostrata
