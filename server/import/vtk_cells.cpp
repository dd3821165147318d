#include "import/vtk_cells.h"

#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkCellTypes.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <array>
#include <map>

#include "base/error.h"
#include "tables/cell_type.h"

namespace isostrata {
namespace {

struct Kept {
  CellType type = CellType::tetrahedron;
  int corners = 0;  // 0: not a cell that can be kept
  bool linearised = false;
};

/// VTK numbers a cell's corners first, whatever its order.
Kept kept_as(int vtk_type) {
  switch (vtk_type) {
    case VTK_TETRA:
      return {CellType::tetrahedron, 4, false};
    case VTK_HEXAHEDRON:
    case VTK_VOXEL:
      return {CellType::hexahedron, 8, false};
    case VTK_WEDGE:
      return {CellType::wedge, 6, false};
    case VTK_PYRAMID:
      return {CellType::pyramid, 5, false};
    case VTK_QUADRATIC_TETRA:
    case VTK_LAGRANGE_TETRAHEDRON:
    case VTK_BEZIER_TETRAHEDRON:
      return {CellType::tetrahedron, 4, true};
    case VTK_QUADRATIC_HEXAHEDRON:
    case VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON:
    case VTK_TRIQUADRATIC_HEXAHEDRON:
    case VTK_LAGRANGE_HEXAHEDRON:
    case VTK_BEZIER_HEXAHEDRON:
      return {CellType::hexahedron, 8, true};
    case VTK_QUADRATIC_WEDGE:
    case VTK_QUADRATIC_LINEAR_WEDGE:
    case VTK_BIQUADRATIC_QUADRATIC_WEDGE:
    case VTK_LAGRANGE_WEDGE:
    case VTK_BEZIER_WEDGE:
      return {CellType::wedge, 6, true};
    case VTK_QUADRATIC_PYRAMID:
    case VTK_TRIQUADRATIC_PYRAMID:
    case VTK_LAGRANGE_PYRAMID:
    case VTK_BEZIER_PYRAMID:
      return {CellType::pyramid, 5, true};
    default:
      return {};
  }
}

/// "VTK_QUADRATIC_TETRA" is what people search for; VTK calls it "vtkQuadraticTetra".
std::string vtk_name(int type) {
  const char* name = vtkCellTypes::GetClassNameFromTypeId(type);
  return name && std::string(name) != "UnknownClass" ? name : "type " + std::to_string(type);
}

}  // namespace

KeptCells keep_cells(vtkUnstructuredGrid* grid, const std::string& name, std::vector<std::string>& notes) {
  KeptCells kept;
  vtkCellArray* cells = grid->GetCells();
  vtkUnsignedCharArray* types = grid->GetCellTypesArray();
  if (!cells || !types) return kept;
  const vtkIdType count = cells->GetNumberOfCells(), points = grid->GetNumberOfPoints();
  const auto broken = [&](const std::string& what) { throw Error(ErrorCode::bad_data, name + ": " + what); };
  if (types->GetNumberOfValues() != count)
    broken(std::to_string(types->GetNumberOfValues()) + " cell types for " + std::to_string(count) + " cells");
  // Offsets are checked here, because IsValid and GetCellAtId trust them.
  const vtkIdType ids = cells->GetNumberOfConnectivityIds();
  const bool wide = cells->IsStorage64Bit();
  const auto offset_at = [&](vtkIdType c) -> vtkIdType {
    return wide ? cells->GetOffsetsArray64()->GetValue(c) : cells->GetOffsetsArray32()->GetValue(c);
  };
  vtkIdType previous = 0;
  for (vtkIdType c = 0; c <= count && count > 0; ++c) {
    const vtkIdType offset = offset_at(c);
    if (offset < previous || offset > ids || (c == 0 && offset != 0))
      broken("offset " + std::to_string(offset) + " of cell " + std::to_string(c) + " is out of order (" + std::to_string(ids) +
             " connectivity entries)");
    previous = offset;
  }

  std::map<int, std::int64_t> skipped, linearised;
  kept.types.reserve(static_cast<std::size_t>(count));
  kept.offsets.reserve(static_cast<std::size_t>(count) + 1);
  vtkNew<vtkIdList> corners;
  for (vtkIdType c = 0; c < count; ++c) {
    const int vtk_type = types->GetValue(c);
    const Kept as = kept_as(vtk_type);
    if (as.corners == 0) {
      ++skipped[vtk_type];
      continue;
    }
    cells->GetCellAtId(c, corners);
    const vtkIdType given = corners->GetNumberOfIds();
    if (as.linearised ? given < as.corners : given != as.corners)
      broken("cell " + std::to_string(c) + " has " + std::to_string(given) + " points; " + vtk_name(vtk_type) + " needs " +
             std::to_string(as.corners));
    if (as.linearised) ++linearised[vtk_type];
    static constexpr std::array<vtkIdType, 8> kFromVoxel{0, 1, 3, 2, 4, 5, 7, 6};
    for (vtkIdType v = 0; v < as.corners; ++v) {
      const vtkIdType id = corners->GetId(vtk_type == VTK_VOXEL ? kFromVoxel[static_cast<std::size_t>(v)] : v);
      if (id < 0 || id >= points)
        broken("cell " + std::to_string(c) + " uses point " + std::to_string(id) + " of " + std::to_string(points));
      kept.connectivity.push_back(id);
    }
    kept.types.push_back(static_cast<std::uint8_t>(as.type));
    kept.offsets.push_back(static_cast<std::int64_t>(kept.connectivity.size()));
    kept.source.push_back(c);
  }
  for (const auto& [type, n] : skipped)
    notes.push_back(std::to_string(n) + " " + vtk_name(type) +
                    " skipped: only tetrahedra, pyramids, wedges and hexahedra are read");
  for (const auto& [type, n] : linearised)
    notes.push_back(std::to_string(n) + " " + vtk_name(type) + " read as linear cells by their corners");
  if (skipped.empty()) kept.source.clear();
  return kept;
}

}  // namespace isostrata
