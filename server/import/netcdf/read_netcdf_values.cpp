#include "import/netcdf/netcdf_values.h"

#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkType.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/error.h"
#include "import/vtk/vtk_type.h"

namespace isostrata {
namespace {

struct Bounds {
  double least = -std::numeric_limits<double>::infinity(), greatest = std::numeric_limits<double>::infinity();
  bool leave_out(double number) const { return number < least || number > greatest; }
};

/// Which stored numbers of a variable stand for no value.
template <class T>
struct NoValue {
  std::vector<T> fills;
  Bounds stored, meant;
  double scale = 1, offset = 0;

  bool operator()(T value) const {
    const auto number = static_cast<double>(value);
    return stored.leave_out(number) || meant.leave_out(number * scale + offset) || std::find(fills.begin(), fills.end(), value) != fills.end();
  }
};

/// The numbers of an attribute that a T can be.
template <class T>
std::vector<T> attribute_as(const NetcdfGroup& file, int variable, const char* attribute) {
  nc_type stored = NC_NAT, type = NC_NAT;
  std::size_t length = 0;
  if (nc_inq_att(file.number(), variable, attribute, &type, &length) != NC_NOERR || nc_inq_vartype(file.number(), variable, &stored) != NC_NOERR) return {};
  std::vector<T> out(length);
  if (type == stored) return nc_get_att(file.number(), variable, attribute, out.data()) == NC_NOERR ? out : std::vector<T>{};
  out.clear();
  for (const double number : file.numbers(variable, attribute))
    if (std::is_floating_point_v<T> || (number >= static_cast<double>(std::numeric_limits<T>::lowest()) && number < std::ldexp(1.0, std::numeric_limits<T>::digits) && number == std::floor(number)))
      out.push_back(static_cast<T>(number));
  return out;
}

/// The library writes a number of its own if nobody has written one, but not for bytes, all of which may be values.
template <class T>
std::vector<T> fills_of(const NetcdfGroup& file, int variable) {
  std::vector<T> fills = attribute_as<T>(file, variable, "_FillValue");
  T own{};
  int none = 1;
  nc_type stored = NC_NAT;
  if (fills.empty() && sizeof(T) > 1 && nc_inq_vartype(file.number(), variable, &stored) == NC_NOERR && stored < NC_FIRSTUSERTYPEID && nc_inq_var_fill(file.number(), variable, &none, &own) == NC_NOERR && !none) fills = {own};
  for (const T missing : attribute_as<T>(file, variable, "missing_value")) fills.push_back(missing);
  return fills;
}

bool is_real(const NetcdfGroup& file, int variable, const char* attribute) {
  nc_type type = NC_NAT;
  return nc_inq_atttype(file.number(), variable, attribute, &type) == NC_NOERR && (type == NC_FLOAT || type == NC_DOUBLE);
}

/// A valid range is of the numbers that are stored, but of the values that they stand for if those are packed as whole numbers and it is of real ones, as the scale is (NetCDF Users
/// Guide, Attribute Conventions: valid_range).
bool is_of_unpacked(const NetcdfGroup& file, int variable, const char* attribute) {
  nc_type stored = NC_NAT;
  const bool whole = nc_inq_vartype(file.number(), variable, &stored) == NC_NOERR && stored != NC_FLOAT && stored != NC_DOUBLE;
  return whole && is_real(file, variable, attribute) && (is_real(file, variable, "scale_factor") || is_real(file, variable, "add_offset"));
}

template <class T>
NoValue<T> no_value(const NetcdfGroup& file, int variable, double scale, double offset) {
  NoValue<T> out{fills_of<T>(file, variable), {}, {}, scale, offset};
  for (const std::string attribute : {"valid_range", "valid_min", "valid_max"}) {
    const bool unpacked = is_of_unpacked(file, variable, attribute.c_str());
    std::vector<double> ends;
    if (unpacked)
      ends = file.numbers(variable, attribute.c_str());
    else
      for (const T end : attribute_as<T>(file, variable, attribute.c_str())) ends.push_back(static_cast<double>(end));
    if (ends.size() != (attribute == "valid_range" ? 2u : 1u)) continue;
    Bounds& bounds = unpacked ? out.meant : out.stored;
    const double rounding = unpacked ? std::abs(scale) / 2 : 0;  // an end is often one of the values, and not to the last digit
    if (attribute != "valid_max") bounds.least = ends.front() - rounding;
    if (attribute != "valid_min") bounds.greatest = ends.back() + rounding;
  }
  return out;
}

template <class Array, class T>
vtkSmartPointer<vtkDataArray> with_gaps(std::span<const T> values, const NoValue<T>& none, double scale, double offset) {
  using To = typename Array::ValueType;
  auto out = vtkSmartPointer<Array>::New();
  out->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
  const bool plain = scale == 1 && offset == 0;
  std::transform(values.begin(), values.end(), out->GetPointer(0), [&](T value) {
    if (none(value)) return std::numeric_limits<To>::quiet_NaN();
    return static_cast<To>(plain ? static_cast<double>(value) : static_cast<double>(value) * scale + offset);
  });
  return out;
}

double one_number(const NetcdfGroup& file, int variable, const char* attribute, double other) {
  const std::vector<double> numbers = file.numbers(variable, attribute);
  return numbers.size() == 1 ? numbers.front() : other;
}

}  // namespace

ScalarType netcdf_stored(vtkDataArray& values) {
  for (const ScalarType type : {ScalarType::int8, ScalarType::uint8, ScalarType::int16, ScalarType::uint16, ScalarType::int32, ScalarType::uint32, ScalarType::int64, ScalarType::uint64, ScalarType::float32})
    if (vtk_type_of(type) == values.GetDataType()) return type;
  return ScalarType::float64;
}

vtkSmartPointer<vtkDataArray> netcdf_values(const NetcdfGroup& file, int variable, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count) {
  const ScalarType type = file.type(variable).value_or(ScalarType::float64);
  const std::size_t values = std::accumulate(count.begin(), count.end(), std::size_t{1}, std::multiplies<>());
  auto stored = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(vtk_type_of(type)));
  stored->SetNumberOfValues(static_cast<vtkIdType>(values));
  if (const int error = nc_get_vara(file.number(), variable, from.data(), count.data(), stored->GetVoidPointer(0)); error != NC_NOERR)
    throw Error(ErrorCode::bad_data, "'" + file.name(variable) + "' cannot be read: " + nc_strerror(error));
  const double scale = one_number(file, variable, "scale_factor", 1), offset = one_number(file, variable, "add_offset", 0);
  const std::span<const std::byte> bytes(static_cast<const std::byte*>(stored->GetVoidPointer(0)), values * size_of(type));
  return std::visit(
      [&](auto span) -> vtkSmartPointer<vtkDataArray> {
        using T = typename decltype(span)::value_type;
        const NoValue<T> none = no_value<T>(file, variable, scale, offset);
        if (scale != 1 || offset != 0) return with_gaps<vtkDoubleArray>(span, none, scale, offset);
        if (std::none_of(span.begin(), span.end(), none)) return stored;
        return (std::is_integral_v<T> && sizeof(T) <= 2) || std::is_same_v<T, float> ? with_gaps<vtkFloatArray>(span, none, 1, 0) : with_gaps<vtkDoubleArray>(span, none, 1, 0);
      },
      scalar_span(type, bytes));
}

}  // namespace isostrata
