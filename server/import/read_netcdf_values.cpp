#include "import/netcdf_values.h"

#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkType.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/error.h"

namespace isostrata {
namespace {

int vtk_type(ScalarType type) {
  switch (type) {
    case ScalarType::int8: return VTK_SIGNED_CHAR;
    case ScalarType::uint8: return VTK_UNSIGNED_CHAR;
    case ScalarType::int16: return VTK_SHORT;
    case ScalarType::uint16: return VTK_UNSIGNED_SHORT;
    case ScalarType::int32: return VTK_INT;
    case ScalarType::uint32: return VTK_UNSIGNED_INT;
    case ScalarType::int64: return VTK_LONG_LONG;
    case ScalarType::uint64: return VTK_UNSIGNED_LONG_LONG;
    case ScalarType::float32: return VTK_FLOAT;
    default: return VTK_DOUBLE;
  }
}

/// Which stored numbers of a variable stand for no value.
template <class T>
struct NoValue {
  std::vector<T> fills;
  double least = -std::numeric_limits<double>::infinity(), greatest = std::numeric_limits<double>::infinity();

  bool operator()(T value) const {
    const auto number = static_cast<double>(value);
    return number < least || number > greatest || std::find(fills.begin(), fills.end(), value) != fills.end();
  }
};

/// The numbers of an attribute that a T can be.
template <class T>
std::vector<T> attribute_as(const NetcdfFile& file, int variable, const char* attribute) {
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

/// The library writes a number of its own where nobody has written one, but not for bytes, all of which may be values.
template <class T>
std::vector<T> fills_of(const NetcdfFile& file, int variable) {
  std::vector<T> fills = attribute_as<T>(file, variable, "_FillValue");
  T own{};
  int none = 1;
  nc_type stored = NC_NAT;
  if (fills.empty() && sizeof(T) > 1 && nc_inq_vartype(file.number(), variable, &stored) == NC_NOERR && stored < NC_FIRSTUSERTYPEID && nc_inq_var_fill(file.number(), variable, &none, &own) == NC_NOERR && !none) fills = {own};
  for (const T missing : attribute_as<T>(file, variable, "missing_value")) fills.push_back(missing);
  return fills;
}

/// `packed`: the range is of the values, and not of the numbers that are stored.
template <class T>
NoValue<T> no_value(const NetcdfFile& file, int variable, bool packed) {
  NoValue<T> out{fills_of<T>(file, variable)};
  if (packed) return out;
  if (const std::vector<T> range = attribute_as<T>(file, variable, "valid_range"); range.size() == 2) out.least = static_cast<double>(range[0]), out.greatest = static_cast<double>(range[1]);
  if (const std::vector<T> least = attribute_as<T>(file, variable, "valid_min"); least.size() == 1) out.least = static_cast<double>(least[0]);
  if (const std::vector<T> greatest = attribute_as<T>(file, variable, "valid_max"); greatest.size() == 1) out.greatest = static_cast<double>(greatest[0]);
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

double one_number(const NetcdfFile& file, int variable, const char* attribute, double other) {
  const std::vector<double> numbers = file.numbers(variable, attribute);
  return numbers.size() == 1 ? numbers.front() : other;
}

}  // namespace

vtkSmartPointer<vtkDataArray> netcdf_values(const NetcdfFile& file, int variable, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count) {
  const ScalarType type = file.type(variable).value_or(ScalarType::float64);
  const std::size_t values = std::accumulate(count.begin(), count.end(), std::size_t{1}, std::multiplies<>());
  auto stored = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(vtk_type(type)));
  stored->SetNumberOfValues(static_cast<vtkIdType>(values));
  if (const int error = nc_get_vara(file.number(), variable, from.data(), count.data(), stored->GetVoidPointer(0)); error != NC_NOERR)
    throw Error(ErrorCode::bad_data, "'" + file.name(variable) + "' cannot be read: " + nc_strerror(error));
  const double scale = one_number(file, variable, "scale_factor", 1), offset = one_number(file, variable, "add_offset", 0);
  const bool packed = !file.numbers(variable, "scale_factor").empty() || !file.numbers(variable, "add_offset").empty();
  const std::span<const std::byte> bytes(static_cast<const std::byte*>(stored->GetVoidPointer(0)), values * size_of(type));
  return std::visit(
      [&](auto span) -> vtkSmartPointer<vtkDataArray> {
        using T = typename decltype(span)::value_type;
        const NoValue<T> none = no_value<T>(file, variable, packed);
        if (scale != 1 || offset != 0) return with_gaps<vtkDoubleArray>(span, none, scale, offset);
        if (std::none_of(span.begin(), span.end(), none)) return stored;
        return (std::is_integral_v<T> && sizeof(T) <= 2) || std::is_same_v<T, float> ? with_gaps<vtkFloatArray>(span, none, 1, 0) : with_gaps<vtkDoubleArray>(span, none, 1, 0);
      },
      scalar_span(type, bytes));
}

}  // namespace isostrata
