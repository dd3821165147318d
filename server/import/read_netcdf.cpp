#include <netcdf.h>
#include <vtkNetCDFCFReader.h>
#include <vtkNew.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "import/check_netcdf.h"
#include "import/mapped_file.h"
#include "import/read_own.h"
#include "import/read_vtk.h"
#include "import/vtk_messages.h"
#include "import/vtk_pipeline.h"

namespace isostrata {
namespace {

/// VTK reads variables over the same dimensions at once: "(time, z, y, x)". The best are those over the most, then those that are the most
/// variables, then the first in the file.
std::string choose_dimensions(vtkNetCDFCFReader* reader, std::vector<std::string>& notes) {
  struct Group {
    std::ptrdiff_t axes = 0, variables = 0, first = 0;
  };
  std::map<std::string, Group> groups;
  vtkStringArray* names = reader->GetAllVariableArrayNames();
  vtkStringArray* of_variables = reader->GetVariableDimensions();
  const vtkIdType count = std::min(names->GetNumberOfValues(), of_variables->GetNumberOfValues());
  for (vtkIdType i = 0; i < count; ++i) {
    const std::string dimensions = of_variables->GetValue(i);
    Group& group = groups[dimensions];
    if (group.variables++ == 0) {
      group.axes = dimensions.size() > 2 ? 1 + std::count(dimensions.begin(), dimensions.end(), ',') : 0;
      group.first = i;
    }
  }
  const auto best = std::max_element(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    return std::tuple(a.second.axes, a.second.variables, -a.second.first) < std::tuple(b.second.axes, b.second.variables, -b.second.first);
  });
  if (best == groups.end() || best->second.axes < 2) return {};
  std::string others;
  int skipped = 0;
  for (vtkIdType i = 0; i < count; ++i) {
    const std::string name = names->GetValue(i), dimensions = of_variables->GetValue(i);
    if (dimensions == best->first) continue;
    if (++skipped <= 8) others += (others.empty() ? "" : ", ") + name + dimensions;
  }
  if (skipped > 0)
    notes.push_back(std::to_string(skipped) + " variables skipped that are not over " + best->first + ": " + others + (skipped > 8 ? ", ..." : ""));
  return best->first;
}

/// A file that VTK has read already, once more.
class NetcdfFile {
 public:
  explicit NetcdfFile(const std::string& path) { open_ = nc_open(path.c_str(), NC_NOWRITE, &file_) == NC_NOERR; }
  ~NetcdfFile() {
    if (open_) nc_close(file_);
  }
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  /// The numbers that stand for no value in a variable, unpacked as VTK unpacks.
  std::vector<double> fills(const std::string& name) const {
    int variable = 0;
    if (!open_ || nc_inq_varid(file_, name.c_str(), &variable) != NC_NOERR) return {};
    const auto number = [&](const char* attribute, double other) {
      std::size_t length = 0;
      double value = other;
      if (nc_inq_attlen(file_, variable, attribute, &length) != NC_NOERR || length != 1 || nc_get_att_double(file_, variable, attribute, &value) != NC_NOERR)
        return other;
      return value;
    };
    const double scale = number("scale_factor", 1), offset = number("add_offset", 0);
    std::vector<double> fills;
    for (const char* attribute : {"_FillValue", "missing_value"})
      if (const double fill = number(attribute, std::numeric_limits<double>::quiet_NaN()); !std::isnan(fill)) fills.push_back(fill * scale + offset);
    return fills;
  }

  /// The least and the greatest value that a variable may have, unpacked; infinite if none is said.
  std::array<double, 2> valid_range(const std::string& name) const {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    std::array<double, 2> range{-kInfinite, kInfinite}, both{};
    int variable = 0;
    std::size_t length = 0;
    if (!open_ || nc_inq_varid(file_, name.c_str(), &variable) != NC_NOERR) return range;
    if (nc_inq_attlen(file_, variable, "valid_range", &length) == NC_NOERR && length == 2 && nc_get_att_double(file_, variable, "valid_range", both.data()) == NC_NOERR) range = both;
    for (const auto& [attribute, end] : {std::pair{"valid_min", 0}, std::pair{"valid_max", 1}})
      if (double value = 0; nc_inq_attlen(file_, variable, attribute, &length) == NC_NOERR && length == 1 && nc_get_att_double(file_, variable, attribute, &value) == NC_NOERR) range[static_cast<std::size_t>(end)] = value;
    return range;
  }
  /// Whether its numbers are others than those that are stored: then the range is not one of the values.
  bool is_packed(const std::string& name) const {
    int variable = 0;
    if (!open_ || nc_inq_varid(file_, name.c_str(), &variable) != NC_NOERR) return false;
    return nc_inq_att(file_, variable, "scale_factor", nullptr, nullptr) == NC_NOERR || nc_inq_att(file_, variable, "add_offset", nullptr, nullptr) == NC_NOERR;
  }

 private:
  int file_ = 0;
  bool open_ = false;
};

template <class T>
void replace_by_nan(FileArray& array, const std::vector<double>& fills, const std::array<double, 2>& valid) {
  const std::span<const T> values(reinterpret_cast<const T*>(array.values.data()), array.values.size() / sizeof(T));
  const auto is_fill = [&](T value) {
    return value < static_cast<T>(valid[0]) || value > static_cast<T>(valid[1]) || std::any_of(fills.begin(), fills.end(), [&](double fill) { return value == static_cast<T>(fill); });
  };
  if (std::none_of(values.begin(), values.end(), is_fill)) return;
  auto copy = std::make_shared<std::vector<T>>(values.begin(), values.end());
  std::replace_if(copy->begin(), copy->end(), is_fill, std::numeric_limits<T>::quiet_NaN());
  array.values = std::as_bytes(std::span<const T>(*copy));
  array.storage = std::move(copy);
}

/// VTK is asked to do this (SetReplaceFillValueWithNan), and 9.3 does not; no version does it for packed numbers or missing_value.
void leave_out_fills(Imported& imported, const NetcdfFile& file) {
  for (Block& block : imported.blocks)
    for (FileArray& array : block.arrays) {
      const std::vector<double> fills = file.fills(array.name);
      constexpr std::array kAny{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
      const std::array<double, 2> valid = file.is_packed(array.name) ? kAny : file.valid_range(array.name);
      if (fills.empty() && valid == kAny) continue;
      if (array.type == ScalarType::float32) replace_by_nan<float>(array, fills, valid);
      if (array.type == ScalarType::float64) replace_by_nan<double>(array, fills, valid);
    }
}

}  // namespace

Imported read_netcdf(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_netcdf_classic(MappedFile(request.file).bytes(), name);
  vtkNew<vtkNetCDFCFReader> reader;
  reader->SetFileName(request.file.c_str());
  reader->SetSphericalCoordinates(0);  // places as the file has them, degrees as well
  reader->SetReplaceFillValueWithNan(1);
  report_progress(reader, request);
  reader->UpdateMetaData();
  throw_on_vtk_error(name);
  std::vector<std::string> notes;
  const std::string dimensions = choose_dimensions(reader, notes);
  if (dimensions.empty())
    throw Error(ErrorCode::unsupported, name + ": netCDF without a variable over two or three axes of space");
  reader->SetDimensions(dimensions.c_str());
  reader->UpdateInformation();
  if (std::count(dimensions.begin(), dimensions.end(), ',') > 2 && listed_times(reader).empty()) return read_netcdf_plainly(request);  // none of the axes says that it is time: WRF's
  Imported imported = read_step(reader, request);
  leave_out_fills(imported, NetcdfFile(request.file.string()));
  imported.notes.insert(imported.notes.end(), notes.begin(), notes.end());
  if (const char* units = reader->GetTimeUnits(); units && *units) imported.notes.push_back("times are in " + std::string(units));
  for (Block& block : imported.blocks)
    for (const FileArray& array : block.arrays)
      if (const std::string units = reader->QueryArrayUnits(array.name.c_str()); !units.empty())
        imported.notes.push_back("unit of '" + array.name + "': " + units);
  return imported;
}

}  // namespace isostrata
