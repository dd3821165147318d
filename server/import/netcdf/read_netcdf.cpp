#include <netcdf.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkNetCDFCFReader.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "import/bytes/mapped_file.h"
#include "import/imported/read_own.h"
#include "import/imported/vtk_messages.h"
#include "import/netcdf/check_netcdf.h"
#include "import/netcdf/netcdf_axes.h"
#include "import/netcdf/netcdf_cells.h"
#include "import/netcdf/netcdf_file.h"
#include "import/netcdf/netcdf_placed.h"
#include "import/netcdf/netcdf_ugrid.h"
#include "import/netcdf/netcdf_values.h"
#include "import/vtk/read_vtk.h"
#include "import/vtk/vtk_pipeline.h"

namespace isostrata {
namespace {

/// VTK's, which makes the grid. Values are read here, of all types and with gaps, and times are numbers of steps: VTK drops those that do not increase.
class NetcdfReader : public vtkNetCDFCFReader {
 public:
  static NetcdfReader* New();
  vtkTypeMacro(NetcdfReader, vtkNetCDFCFReader);

  void set_file(const NetcdfFile& file) { file_ = &file; }
  /// A dimension whose places are steps, though it does not say that it is time. The metadata is read again.
  void count_along(int dimension) {
    counted_ = dimension;
    FileNameMTime.Modified();
    UpdateMetaData();
  }
  bool is_time(int dimension) { return IsTimeDimension(0, dimension) != 0; }
  void set_steps(NetcdfSteps steps) { steps_ = std::move(steps), Modified(); }
  std::vector<int> loading() const { return {LoadingDimensions->GetPointer(0), LoadingDimensions->GetPointer(0) + LoadingDimensions->GetNumberOfTuples()}; }

 protected:
  int IsTimeDimension(int file, int dimension) override { return dimension == counted_ ? 1 : vtkNetCDFCFReader::IsTimeDimension(file, dimension); }
  vtkSmartPointer<vtkDoubleArray> GetTimeValues(int, int) override {
    auto numbers = vtkSmartPointer<vtkDoubleArray>::New();
    for (std::size_t step = 0; step < steps_.times.size(); ++step) numbers->InsertNextValue(static_cast<double>(step));
    return numbers;
  }
  int LoadVariable(int, const char* name, double time, vtkDataSet* output) override {
    try {
      const int variable = file_->variable(name).value();
      if (!file_->type(variable)) return 1;  // VTK turns on whatever has the dimensions
      const auto [from, count] = part(variable, static_cast<std::size_t>(time), output);
      const vtkSmartPointer<vtkDataArray> values = netcdf_values(*file_, variable, from, count);
      values->SetName(name);
      DimensionsAreForPointData(LoadingDimensions) ? output->GetPointData()->AddArray(values) : output->GetCellData()->AddArray(values);
      return 1;
    } catch (const Error& error) {
      vtkErrorMacro(<< error.what());
      return 0;
    }
  }

 private:
  /// From where and how many along each of a variable's dimensions.
  std::pair<std::vector<std::size_t>, std::vector<std::size_t>> part(int variable, std::size_t step, vtkDataSet* output) {
    const std::vector<int> dimensions = file_->dimensions(variable);
    const std::size_t before = !dimensions.empty() && is_time(dimensions.front()) ? 1 : 0, axes = dimensions.size() - before;
    int extent[6];
    GetUpdateExtentForOutput(output, extent);
    const int fewer = DimensionsAreForPointData(LoadingDimensions) ? 0 : 1;
    std::vector<std::size_t> from(dimensions.size()), count(dimensions.size(), 1);
    if (before) from[0] = steps_.index.at(dimensions.front()).at(step);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const int* ends = extent + 2 * (axes - 1 - axis);
      from[before + axis] = static_cast<std::size_t>(ends[0]);
      count[before + axis] = static_cast<std::size_t>(ends[1] - ends[0] + 1 - fewer);
    }
    return {from, count};
  }

  const NetcdfFile* file_ = nullptr;
  int counted_ = -1;
  NetcdfSteps steps_;
};
vtkStandardNewMacro(NetcdfReader);

/// Variables over the same dimensions, apart from time: "(z, y, x)" to VTK.
struct Group {
  std::ptrdiff_t axes = 0, variables = 0, first = 0;
  bool timed = false;
  std::vector<int> dimensions;  // of the first, with time

  /// VTK reads three axes of space. A fourth that does not say that it is time counts steps, if no variable has both.
  std::ptrdiff_t rank() const { return axes == 3 && timed ? 5 : axes < 4 || dimensions.size() == 4 ? axes : 0; }
};

/// The best are those over the most, then those that are the most variables, then the first in the file.
std::pair<std::string, Group> choose_group(NetcdfReader& reader, const NetcdfFile& file) {
  std::map<std::string, Group> groups;
  vtkStringArray* names = reader.GetAllVariableArrayNames();
  vtkStringArray* of_variables = reader.GetVariableDimensions();
  const vtkIdType count = std::min(names->GetNumberOfValues(), of_variables->GetNumberOfValues());
  for (vtkIdType i = 0; i < count; ++i) {
    const std::string dimensions = of_variables->GetValue(i);
    const std::optional<int> variable = file.variable(names->GetValue(i));
    if (!variable || !file.type(*variable)) continue;
    Group& group = groups[dimensions];
    const std::vector<int> over = file.dimensions(*variable);
    if (group.variables++ == 0) {
      group.axes = dimensions.size() > 2 ? 1 + std::count(dimensions.begin(), dimensions.end(), ',') : 0;
      group.first = i;
      group.dimensions = over;
    }
    group.timed = group.timed || static_cast<std::ptrdiff_t>(over.size()) > group.axes;
  }
  const auto best = std::max_element(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    return std::tuple(a.second.rank(), a.second.variables, -a.second.first) < std::tuple(b.second.rank(), b.second.variables, -b.second.first);
  });
  if (best == groups.end() || best->second.rank() < 2) return {};
  return *best;
}

/// Turns on the variables over these dimensions, and returns those that hold numbers.
std::vector<int> turn_on(NetcdfReader& reader, const NetcdfFile& file, const std::string& dimensions, std::vector<std::string>& notes) {
  reader.SetDimensions(dimensions.c_str());
  vtkStringArray* names = reader.GetAllVariableArrayNames();
  vtkStringArray* of_variables = reader.GetVariableDimensions();
  std::vector<int> on;
  std::string others;
  int skipped = 0;
  for (vtkIdType i = 0; i < std::min(names->GetNumberOfValues(), of_variables->GetNumberOfValues()); ++i) {
    const std::string name = names->GetValue(i), over = of_variables->GetValue(i);
    const std::optional<int> variable = file.variable(name);
    if (over != dimensions) {
      if (++skipped <= 8) others += (others.empty() ? "" : ", ") + name + over;
    } else if (!variable || !file.type(*variable)) {
      notes.push_back("variable '" + name + "' skipped: it holds text or records, not numbers");
    } else {
      on.push_back(*variable);
    }
  }
  if (skipped > 0)
    notes.push_back(std::to_string(skipped) + " variables skipped that are not over " + dimensions + ": " + others + (skipped > 8 ? ", ..." : ""));
  return on;
}

/// The dimensions in front of variables that are time, each once.
std::vector<int> time_dimensions(NetcdfReader& reader, const NetcdfFile& file, const std::vector<int>& variables) {
  std::vector<int> out;
  for (const int variable : variables)
    if (const std::vector<int> over = file.dimensions(variable); !over.empty() && reader.is_time(over.front()) && std::find(out.begin(), out.end(), over.front()) == out.end()) out.push_back(over.front());
  return out;
}

void refuse_particles(const NetcdfFile& file, const std::string& name) {
  if (file.text(NC_GLOBAL, "Conventions").find("AMBER") != std::string::npos)
    throw Error(ErrorCode::unsupported, name + ": particles (AMBER); expected a grid: save their density on one, as Gaussian cube, MRC or .npy");
}

/// Nothing was written along such a dimension yet. VTK takes its first place all the same.
void refuse_empty(const NetcdfFile& file, const std::vector<int>& dimensions, const std::string& name) {
  for (const int dimension : dimensions)
    if (file.length(dimension) == 0)
      throw Error(ErrorCode::bad_data, name + ": its dimension '" + file.dimension_name(dimension) + "' has length 0; expected at least one step or place along it");
}

/// VTK turns an axis that says that it goes down, an even one without its origin. Pressures do not say it.
void place_downward(Grid& grid, const NetcdfFile& file, const std::vector<int>& dimensions) {
  auto* const uniform = std::get_if<UniformGrid>(&grid.shape);
  auto* const rectilinear = std::get_if<RectilinearGrid>(&grid.shape);
  for (std::size_t axis = 0; axis < std::min<std::size_t>(dimensions.size(), 3); ++axis) {
    const int dimension = dimensions[dimensions.size() - 1 - axis];
    const std::optional<NetcdfVariable> coordinate = file.coordinate(dimension);
    if (!coordinate || netcdf_axis(file, dimension).positive != "down") continue;
    const bool turned = coordinate->text("positive") == "down";
    if (rectilinear && !turned)
      for (double& place : rectilinear->axes[axis]) place = -place;
    if (!uniform) continue;
    const auto a = static_cast<int>(axis);
    if (!turned) uniform->spacing[a] = -uniform->spacing[a];
    if (const std::vector<double> places = coordinate->values(); turned && !places.empty())
      uniform->origin[a] = -places.front();
    else if (!turned)
      uniform->origin[a] = -uniform->origin[a];
  }
}

/// Whether variables over these dimensions have their time behind another axis, or say where their points are in another group or in packed numbers: all unknown to VTK's reader.
bool is_beyond(const NetcdfFile& file, const std::vector<int>& dimensions) {
  const auto time = std::find_if(dimensions.begin(), dimensions.end(), [&](int dimension) { return is_netcdf_time(file, dimension); });
  if (time != dimensions.begin() && time != dimensions.end() && dimensions.size() > 2) return true;
  return std::any_of(dimensions.begin(), dimensions.end(), [&](int dimension) {
    const std::optional<NetcdfVariable> coordinate = file.coordinate(dimension);
    return coordinate && (coordinate->group.number() != file.number() || coordinate->is_packed());
  });
}

/// Whether a block's points are the places along these dimensions, and its values on them: VTK's reader makes cells of values whose places have bounds.
bool is_over(const Block& block, const NetcdfFile& file, const std::vector<int>& dimensions) {
  if (!block.grid.structured() || dimensions.size() > 3) return false;
  const auto dims = block.grid.dims();
  for (std::size_t a = 0; a < 3; ++a)
    if (dims[a] != static_cast<std::int64_t>(a < dimensions.size() ? file.length(dimensions[dimensions.size() - 1 - a]) : 1)) return false;
  return std::none_of(block.arrays.begin(), block.arrays.end(), [](const FileArray& array) { return array.on_cells; });
}

}  // namespace

Imported read_netcdf(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_netcdf_classic(MappedFile(request.file).bytes(), name);
  const NetcdfFile file(request.file);
#ifdef ISOSTRATA_READS_EXODUS
  if (file.is_exodus()) return read_exodus(request);
#endif
  refuse_particles(file, name);
  if (auto mesh = read_netcdf_ugrid(file, request)) return std::move(*mesh);
  if (auto cells = read_netcdf_cells(file, request)) return std::move(*cells);
  std::vector<int> placed = file.dimensions();
  std::erase_if(placed, [&](int dimension) { return !file.coordinate(dimension); });
  refuse_empty(file, placed, name);
  const auto has_names = [&](int dimension) { return file.coordinate(dimension)->values().empty(); };  // VTK's reader takes numbers alone
  if (std::any_of(placed.begin(), placed.end(), has_names))
    if (auto imported = read_netcdf_placed(file, request)) return std::move(*imported);
  vtkNew<NetcdfReader> reader;
  reader->set_file(file);
  reader->SetFileName(request.file.c_str());
  reader->SetSphericalCoordinates(0);  // places as the file has them, degrees as well
  report_progress(reader, request);
  reader->UpdateMetaData();
  throw_on_vtk_error(name);
  auto [dimensions, group] = choose_group(*reader, file);
  if (is_beyond(file, group.dimensions) || (!dimensions.empty() && netcdf_axes_in_groups(file) > static_cast<std::size_t>(std::min<std::ptrdiff_t>(group.axes, 3))))
    if (auto placed = read_netcdf_placed(file, request)) return std::move(*placed);
  const bool said_time = !dimensions.empty() && is_netcdf_time(file, group.dimensions.front());  // by its name, where VTK's reader knows no such unit
  if (group.axes == 4 || (group.axes == 3 && said_time && !reader->is_time(group.dimensions.front()))) {
    reader->count_along(group.dimensions.front());
    dimensions = choose_group(*reader, file).first;
  }
  if (dimensions.empty()) {
    if (file.has_groups() || file.has_many_axes()) {
      if (auto placed = read_netcdf_placed(file, request)) return std::move(*placed);
      return read_netcdf_plainly(request);
    }
    throw Error(ErrorCode::unsupported, name + ": netCDF without a variable over two or three axes of space");
  }
  std::vector<std::string> notes;
  const std::vector<int> variables = turn_on(*reader, file, dimensions, notes), timed = time_dimensions(*reader, file, variables);
  for (const int variable : variables) refuse_empty(file, file.dimensions(variable), name);
  const NetcdfSteps steps = netcdf_steps(file, timed, name);
  reader->set_steps(steps);
  reader->UpdateInformation();
  Imported imported = read_step(reader, request);
  if (!steps.times.empty()) imported.times = steps.times;
  const std::vector<int> over = reader->loading();
  const auto says = std::find_if(variables.begin(), variables.end(), [&](int variable) { return !file.text(variable, "coordinates").empty(); });
  const int first = says == variables.end() ? variables.front() : *says;
  CfMoment moment;
  if (const std::vector<int> all = file.dimensions(first); !timed.empty() && all.front() == timed.front())
    moment = {timed.front(), steps.index.at(timed.front()).at(static_cast<std::size_t>(request.step))};
  imported.axes = netcdf_meaning(file, over);
  for (Block& block : imported.blocks) {
    if (const auto curved = is_over(block, file, over) ? place_netcdf_on_curves(block, {file, first}, over, moment, imported.notes) : std::nullopt) {
      imported.axes = *curved;
      continue;
    }
    place_downward(block.grid, file, over);
    if (const auto from = netcdf_turned(file, over)) turn_block(block, *from);
  }
  imported.notes.insert(imported.notes.end(), notes.begin(), notes.end());
  if (!steps.sorted) imported.notes.push_back(kTimesWereSorted);
  if (!steps.units.empty()) imported.notes.push_back("times are in " + steps.units);
  for (Block& block : imported.blocks)
    for (FileArray& array : block.arrays) array.unit = reader->QueryArrayUnits(array.name.c_str());
  return imported;
}

}  // namespace isostrata
