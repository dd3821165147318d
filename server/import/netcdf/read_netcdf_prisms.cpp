#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>

#include "import/netcdf/netcdf_prisms.h"
#include "import/vtk/set_cells.h"

namespace isostrata {
namespace {

int type_of(std::size_t corners, bool flat) {
  if (corners < 3) return VTK_EMPTY_CELL;
  if (flat) return corners == 3 ? VTK_TRIANGLE : corners == 4 ? VTK_QUAD : VTK_POLYGON;
  static constexpr std::array kPrisms{VTK_WEDGE, VTK_HEXAHEDRON, VTK_PENTAGONAL_PRISM, VTK_HEXAGONAL_PRISM};
  return corners <= 6 ? kPrisms[corners - 3] : VTK_EMPTY_CELL;
}

}  // namespace

std::vector<double> ends_of_levels(const std::vector<double>& levels) {
  if (levels.size() < 2) return levels;
  std::vector<double> out{levels[0] - (levels[1] - levels[0]) / 2};
  for (std::size_t k = 1; k < levels.size(); ++k) out.push_back((levels[k - 1] + levels[k]) / 2);
  out.push_back(levels.back() + (levels.back() - levels[levels.size() - 2]) / 2);
  return out;
}

Prisms prisms_of(const Outlines& outlines, const std::vector<double>& heights, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::int64_t corners = 0;
  for (const auto& around : outlines.of_cells) corners += std::ssize(around);
  check_bytes(request, static_cast<std::uint64_t>(checked_product({std::ssize(heights), corners + 3 * std::ssize(outlines.points), 16}, name)), name);
  vtkNew<vtkDoubleArray> places;
  places->SetNumberOfComponents(3);
  for (const double z : heights)
    for (const auto& point : outlines.points) places->InsertNextTuple3(point[0], point[1], z);
  Prisms out;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> ends{0}, ids;
  const bool flat = heights.size() == 1;
  const std::size_t layers = flat ? 1 : heights.size() - 1;
  for (std::size_t k = 0; k < layers; ++k)
    for (std::size_t c = 0; c < outlines.of_cells.size(); ++c) {
      const std::vector<std::int64_t>& around = outlines.of_cells[c];
      const int type = type_of(around.size(), flat);
      if (type == VTK_EMPTY_CELL) {
        ++out.left_out;
        continue;
      }
      for (std::size_t sheet = k; sheet <= k + (flat ? 0 : 1); ++sheet)
        for (const std::int64_t corner : around) ids.push_back(corner + static_cast<std::int64_t>(sheet * outlines.points.size()));
      types.push_back(static_cast<std::uint8_t>(type));
      ends.push_back(std::ssize(ids));
      out.kept.emplace_back(k, c);
    }
  vtkNew<vtkPoints> points;
  points->SetData(places);
  out.grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  out.grid->SetPoints(points);
  set_cells(out.grid, types, ends, ids);
  return out;
}

vtkSmartPointer<vtkDataArray> taken(vtkDataArray& values, const std::vector<std::pair<std::size_t, std::size_t>>& which, std::size_t layers, std::size_t places, bool places_first) {
  vtkNew<vtkIdList> ids;
  ids->SetNumberOfIds(static_cast<vtkIdType>(which.size()));
  for (std::size_t i = 0; i < which.size(); ++i) {
    const auto [layer, place] = which[i];
    ids->SetId(static_cast<vtkIdType>(i), static_cast<vtkIdType>(places_first ? place * layers + layer : layer * places + place));
  }
  auto own = vtkSmartPointer<vtkDataArray>::Take(values.NewInstance());
  own->SetNumberOfTuples(ids->GetNumberOfIds());
  values.GetTuples(ids, own);
  return own;
}

}  // namespace isostrata
