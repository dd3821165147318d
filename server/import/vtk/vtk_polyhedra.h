// The faces of a vtkUnstructuredGrid's polyhedra, as each version of VTK keeps them.
#pragma once

#include <vtkIdList.h>
#include <vtkNew.h>

#include <cstdint>
#include <vector>

#include "data/grids/split_polyhedron.h"
#include "import/vtk/cell_checks.h"

class vtkUnstructuredGrid;

namespace isostrata {

class VtkPolyhedra {
 public:
  /// Both must outlive it.
  VtkPolyhedra(vtkUnstructuredGrid* grid, const CellChecks& checks) : grid_(grid), checks_(checks) {}
  /// What read() trusts. Throws bad_data.
  void check() const;
  /// Of one cell, a polyhedron, in place of what is in `to`. Throws bad_data.
  void read(vtkIdType cell, PolyhedronFaces& to);

 private:
  vtkUnstructuredGrid* grid_;
  const CellChecks& checks_;
  vtkNew<vtkIdList> face_ids_, corners_;
  std::vector<std::int64_t> cycle_;
};

}  // namespace isostrata
