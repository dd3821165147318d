#include "import/vtk/cell_checks.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>

#include "base/error.h"
#include "import/vtk/cell_counts.h"

namespace isostrata {

void CellChecks::broken(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": " + what); }

void CellChecks::offsets(vtkCellArray* cells, const std::string& what) const {
  const vtkIdType ids = cells->GetNumberOfConnectivityIds(), count = cells->GetNumberOfCells();
  vtkDataArray* const all = cells->GetOffsetsArray();  // of 32 or of 64 bits
  vtkIdType previous = 0;
  for (vtkIdType c = 0; c <= count && count > 0; ++c) {
    const auto offset = static_cast<vtkIdType>(all->GetComponent(c, 0));
    if (offset < previous || offset > ids || (c == 0 && offset != 0))
      broken("offset " + std::to_string(offset) + " of " + what + " " + std::to_string(c) + " is out of order (" +
             std::to_string(ids) + " connectivity entries)");
    previous = offset;
  }
}

void CellChecks::count(vtkIdType cell, int vtk_type, vtkIdType given, vtkIdType wanted, bool or_more) const {
  if (or_more ? given < wanted : given != wanted)
    broken("cell " + std::to_string(cell) + " has " + std::to_string(given) + " points; " + vtk_name(vtk_type) + " needs " +
           std::to_string(wanted));
}

}  // namespace isostrata
