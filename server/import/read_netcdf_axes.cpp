#include "import/netcdf_axes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <numeric>
#include <string_view>
#include <utility>
#include <variant>

#include "base/error.h"

namespace isostrata {
namespace {

/// A dimension without numbers of its own counts.
std::vector<double> times_along(const NetcdfGroup& file, int dimension, const std::string& name) {
  std::vector<double> times(file.length(dimension));
  std::iota(times.begin(), times.end(), 0.0);
  const std::optional<NetcdfVariable> coordinate = file.coordinate(dimension);
  if (!coordinate || !coordinate->type()) return times;
  const std::vector<double> own = coordinate->values();
  if (own.size() != times.size()) return times;
  const auto bad = std::find_if(own.begin(), own.end(), [](double time) { return !std::isfinite(time); });
  if (bad != own.end()) throw Error(ErrorCode::bad_data, name + ": time " + std::to_string(bad - own.begin()) + " of '" + coordinate->name() + "' is not a finite number");
  return own;
}

std::optional<std::size_t> by_name(const std::string& name) {
  const auto letter = static_cast<std::size_t>((name.empty() ? 0 : name.front() | 0x20) - 'x');
  return name.size() == 1 && letter < 3 ? std::optional(letter) : std::nullopt;
}

/// 0, 1 or 2 for an axis that says that it is x, y or z.
std::optional<std::size_t> direction(const NetcdfGroup& file, int dimension) {
  const std::optional<NetcdfVariable> coordinate = file.coordinate(dimension);
  if (!coordinate) return by_name(file.dimension_name(dimension));
  const auto is_one_of = [](const std::string& text, std::initializer_list<std::string_view> words) { return std::find(words.begin(), words.end(), text) != words.end(); };
  const std::string axis = coordinate->text("axis"), units = coordinate->text("units"), called = coordinate->name();
  if (is_one_of(axis, {"X", "Y", "Z"})) return static_cast<std::size_t>(axis.front() - 'X');
  if (is_one_of(units, {"degrees_east", "degree_east", "degrees_E", "degree_E", "degreesE", "degreeE"})) return 0;
  if (is_one_of(units, {"degrees_north", "degree_north", "degrees_N", "degree_N", "degreesN", "degreeN"})) return 1;
  if (is_one_of(coordinate->text("positive"), {"up", "down"})) return 2;
  return by_name(called);
}

template <class T>
std::array<T, 3> turned(const std::array<T, 3>& before, const std::array<std::size_t, 3>& from) {
  return {before[from[0]], before[from[1]], before[from[2]]};
}

void turn_values(FileArray& array, const std::array<std::int64_t, 3>& dims, const std::array<std::size_t, 3>& from) {
  const std::size_t width = size_of(array.type) * static_cast<std::size_t>(array.components);
  const std::array<std::int64_t, 3> strides{1, dims[0], dims[0] * dims[1]}, size = turned(dims, from), stride = turned(strides, from);
  auto [storage, values] = allocate<std::byte>(array.values.size());
  std::byte* to = values.data();
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i, to += width)
        std::memcpy(to, array.values.data() + static_cast<std::size_t>(i * stride[0] + j * stride[1] + k * stride[2]) * width, width);
  array.values = values;
  array.storage = storage;
}

}  // namespace

NetcdfSteps netcdf_steps(const NetcdfGroup& file, const std::vector<int>& dimensions, const std::string& name) {
  NetcdfSteps steps;
  for (const int dimension : dimensions) {
    const std::vector<double> along = times_along(file, dimension, name);
    if (dimensions.size() == 1) steps.sorted = std::is_sorted(along.begin(), along.end());
    steps.times.insert(steps.times.end(), along.begin(), along.end());
    if (const auto coordinate = file.coordinate(dimension); coordinate && steps.units.empty()) {
      steps.units = coordinate->text("units");
      // What day it is depends on it: models have years of 365 and of 360 days.
      if (const std::string calendar = coordinate->text("calendar"); !steps.units.empty() && !calendar.empty()) steps.units += ", calendar " + calendar;
    }
  }
  if (dimensions.size() == 1) {
    std::vector<std::size_t>& order = steps.index[dimensions.front()];
    order.resize(steps.times.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return steps.times[a] < steps.times[b]; });
    std::sort(steps.times.begin(), steps.times.end());
    return steps;
  }
  std::sort(steps.times.begin(), steps.times.end());
  steps.times.erase(std::unique(steps.times.begin(), steps.times.end()), steps.times.end());
  for (const int dimension : dimensions) {
    const std::vector<double> along = times_along(file, dimension, name);
    for (const double time : steps.times) {
      const auto at = std::find_if(along.begin(), along.end(), [&](double one) { return one >= time; });
      steps.index[dimension].push_back(static_cast<std::size_t>(std::min(at - along.begin(), static_cast<std::ptrdiff_t>(along.size()) - 1)));
    }
  }
  return steps;
}

std::optional<std::array<std::size_t, 3>> netcdf_turned(const NetcdfGroup& file, const std::vector<int>& dimensions) {
  if (dimensions.size() == 2 && direction(file, dimensions[0]) == 0u && direction(file, dimensions[1]) == 1u) return std::array<std::size_t, 3>{1, 0, 2};
  if (dimensions.size() != 3) return std::nullopt;
  constexpr std::size_t kNone = 3;
  std::array<std::size_t, 3> of{kNone, kNone, kNone};
  std::size_t known = 0, sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::optional<std::size_t> along = direction(file, dimensions[2 - axis]);
    if (!along) continue;
    if (of[*along] != kNone) return std::nullopt;
    of[*along] = axis;
    sum += axis;
    ++known;
  }
  if (known < 2) return std::nullopt;
  std::replace(of.begin(), of.end(), kNone, 3 - sum);
  return of == std::array<std::size_t, 3>{0, 1, 2} ? std::nullopt : std::optional(of);
}

void turn_block(Block& block, const std::array<std::size_t, 3>& from) {
  const bool on_points = std::none_of(block.arrays.begin(), block.arrays.end(), [](const FileArray& array) { return array.on_cells; });
  if (!on_points || !block.grid.rectilinear()) return;
  const std::array<std::int64_t, 3> dims = block.grid.dims();
  for (FileArray& array : block.arrays) turn_values(array, dims, from);
  if (auto* uniform = std::get_if<UniformGrid>(&block.grid.shape)) {
    const Vec3d origin = uniform->origin, spacing = uniform->spacing;
    uniform->dims = turned(dims, from);
    for (int a = 0; a < 3; ++a) {
      uniform->origin[a] = origin[static_cast<int>(from[static_cast<std::size_t>(a)])];
      uniform->spacing[a] = spacing[static_cast<int>(from[static_cast<std::size_t>(a)])];
    }
  } else if (auto* rectilinear = std::get_if<RectilinearGrid>(&block.grid.shape)) {
    rectilinear->dims = turned(dims, from);
    rectilinear->axes = turned(rectilinear->axes, from);
  }
}

}  // namespace isostrata
