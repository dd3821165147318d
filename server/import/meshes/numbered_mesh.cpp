#include "import/meshes/numbered_mesh.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <variant>

#include "import/vtk/set_cells.h"
#include "import/vtk/vtk_blocks.h"

namespace isostrata {

const ElementKind* find_kind(std::span<const ElementKind> kinds, std::int64_t type) {
  const auto at = std::find_if(kinds.begin(), kinds.end(), [&](const ElementKind& one) { return one.type == type; });
  return at == kinds.end() ? nullptr : &*at;
}

std::vector<double> times_of(const std::map<std::int64_t, double>& by_step) {
  std::vector<double> times, numbers;
  for (const auto& [number, time] : by_step) numbers.push_back(static_cast<double>(number)), times.push_back(time);
  const bool increase = std::adjacent_find(times.begin(), times.end(), [](double a, double b) { return !(a < b); }) == times.end();
  return increase ? times : numbers;
}

void Numbering::close(const std::string& name, const char* what) {
  if (!std::is_sorted(all_.begin(), all_.end())) std::sort(all_.begin(), all_.end());
  const auto twice = std::adjacent_find(all_.begin(), all_.end(), [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice != all_.end()) throw Error(ErrorCode::bad_data, name + ": has two " + what + " of number " + std::to_string(twice->first));
}

std::optional<std::int64_t> Numbering::place(std::int64_t number) const {
  if (all_.empty() || number < all_.front().first || number > all_.back().first) return std::nullopt;
  const auto straight = static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(all_.front().first);  // most files leave no gaps
  if (straight < all_.size() && all_[straight].first == number) return all_[straight].second;
  const auto at = std::lower_bound(all_.begin(), all_.end(), number, [](const auto& one, std::int64_t of) { return one.first < of; });
  return at->first == number ? std::optional(at->second) : std::nullopt;
}

void NumberedMesh::add_element(std::int64_t number, const ElementKind& kind, std::span<const std::int64_t> numbers, const std::string& name) {
  const auto add = [&](int v) {
    const auto place = nodes.place(numbers[static_cast<std::size_t>(v)]);
    if (!place) throw Error(ErrorCode::bad_data, name + ": element " + std::to_string(number) + " uses node " + std::to_string(numbers[static_cast<std::size_t>(v)]) + ", which is not there");
    ids.push_back(*place);
  };
  if (kind.order.empty())
    for (int v = 0; v < kind.nodes; ++v) add(v);
  else
    for (const int v : kind.order) add(v);
  elements.add(number);
  types.push_back(static_cast<std::uint8_t>(kind.vtk_type));
  ends.push_back(std::ssize(ids));
}

void NumberedMesh::append_to(Imported& imported, const ReadRequest& request) {
  std::uint64_t bytes = points.size() * sizeof(Vec3d) + ids.size() * sizeof(std::int64_t);
  for (const NumberedArray& array : arrays) bytes += array.values.size() * sizeof(double);
  check_bytes(request, bytes, request.file.filename().string());
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkDoubleArray> places;
  places->SetNumberOfComponents(3);
  places->SetNumberOfTuples(std::ssize(points));
  std::memcpy(places->GetPointer(0), points.data(), points.size() * sizeof(Vec3d));
  vtkNew<vtkPoints> as_points;
  as_points->SetData(places);
  grid->SetPoints(as_points);
  set_cells(grid, types, ends, ids);
  for (const NumberedArray& array : arrays) {
    vtkNew<vtkDoubleArray> values;
    values->SetName(array.name.c_str());
    values->SetNumberOfComponents(array.components);
    values->SetNumberOfTuples(std::ssize(array.values) / array.components);
    std::copy(array.values.begin(), array.values.end(), values->GetPointer(0));
    (array.on_cells ? static_cast<vtkDataSetAttributes*>(grid->GetCellData()) : grid->GetPointData())->AddArray(values);
  }
  append_vtk_blocks(grid, request, false, imported.blocks, imported.notes);
  for (FileArray& array : imported.blocks.back().arrays) {
    const auto values = std::get<std::span<const double>>(scalar_span(array.type, array.values));
    array.partial = array.on_cells && std::any_of(values.begin(), values.end(), [](double value) { return std::isnan(value); });
  }
}

}  // namespace isostrata
