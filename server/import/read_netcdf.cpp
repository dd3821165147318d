#include <vtkNetCDFCFReader.h>
#include <vtkNew.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "import/check_netcdf.h"
#include "import/mapped_file.h"
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
  Imported imported = read_step(reader, request);
  imported.notes.insert(imported.notes.end(), notes.begin(), notes.end());
  if (const char* units = reader->GetTimeUnits(); units && *units) imported.notes.push_back("times are in " + std::string(units));
  for (Block& block : imported.blocks)
    for (const FileArray& array : block.arrays)
      if (const std::string units = reader->QueryArrayUnits(array.name.c_str()); !units.empty())
        imported.notes.push_back("unit of '" + array.name + "': " + units);
  return imported;
}

}  // namespace isostrata
