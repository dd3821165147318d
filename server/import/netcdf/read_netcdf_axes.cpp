#include "import/netcdf/netcdf_axes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <utility>
#include <variant>

#include "base/error.h"
#include "import/netcdf/netcdf_values.h"

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

std::vector<CfAxis> axes_along(const NetcdfGroup& file, const std::vector<int>& dimensions) {
  std::vector<CfAxis> axes;
  for (const int dimension : dimensions) axes.push_back(netcdf_axis(file, dimension));
  return axes;
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

/// Those of a group and of the groups that it lies in.
class NetcdfVariables : public CfVariables {
 public:
  explicit NetcdfVariables(const NetcdfGroup& group) : group_(group) {}

  std::vector<std::string> names() const override {
    std::vector<std::string> out;
    for (int variable = 0; variable < group_.variables(); ++variable) out.push_back(group_.name(variable));
    return out;
  }
  std::optional<std::vector<int>> dimensions(const std::string& name) const override {
    const auto of = find(name);
    return of && of->type() ? std::optional(of->group.dimensions(of->variable)) : std::nullopt;
  }
  std::size_t length(int dimension) const override { return group_.length(dimension); }
  CfAxis axis(int dimension) const override { return netcdf_axis(group_, dimension); }
  std::string text(const std::string& name, const char* attribute) const override {
    const auto of = find(name);
    return of ? of->text(attribute) : "";
  }
  std::vector<double> values(const std::string& name, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count) const override {
    const auto of = find(name);
    if (!of) return {};
    const vtkSmartPointer<vtkDataArray> numbers = netcdf_values(of->group, of->variable, from, count);
    std::vector<double> out(static_cast<std::size_t>(numbers->GetNumberOfValues()));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = numbers->GetComponent(static_cast<vtkIdType>(i), 0);
    return out;
  }

 private:
  std::optional<NetcdfVariable> find(const std::string& name) const {
    NetcdfGroup group = group_;
    for (int parent = 0;; group = NetcdfGroup(parent)) {
      if (const auto own = group.variable(name)) return NetcdfVariable{group, *own};
      if (nc_inq_grp_parent(group.number(), &parent) != NC_NOERR) return std::nullopt;
    }
  }
  NetcdfGroup group_;
};

}  // namespace

std::optional<Axes> place_netcdf_on_curves(Block& block, const NetcdfVariable& of, const std::vector<int>& space, const CfMoment& moment, std::vector<std::string>& notes) {
  return place_on_curves(block, NetcdfVariables(of.group), of.name(), space, moment, notes);
}

NetcdfSteps netcdf_steps(const NetcdfGroup& file, const std::vector<int>& dimensions, const std::string& name) {
  NetcdfSteps steps;
  for (const int dimension : dimensions) {
    const std::vector<double> along = times_along(file, dimension, name);
    steps.times.insert(steps.times.end(), along.begin(), along.end());
    if (const auto coordinate = file.coordinate(dimension); coordinate && steps.units.empty()) steps.units = cf_time_units(netcdf_axis(file, dimension));
  }
  if (dimensions.size() == 1) {
    CfSteps sorted = cf_steps(steps.times);
    steps.times = std::move(sorted.times);
    steps.index[dimensions.front()] = std::move(sorted.order);
    steps.sorted = sorted.sorted;
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

CfAxis netcdf_axis(const NetcdfGroup& file, int dimension) {
  const std::optional<NetcdfVariable> of = file.coordinate(dimension);
  if (!of) return {file.dimension_name(dimension)};
  return cf_axis(of->name(), [&](const char* attribute) { return of->text(attribute); });
}

std::optional<std::array<std::size_t, 3>> netcdf_turned(const NetcdfGroup& file, const std::vector<int>& dimensions) { return cf_turned(axes_along(file, dimensions)); }

Axes netcdf_meaning(const NetcdfGroup& file, const std::vector<int>& dimensions) { return cf_axes(axes_along(file, dimensions)); }

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
