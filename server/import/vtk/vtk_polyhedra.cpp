#include "import/vtk/vtk_polyhedra.h"

#include <vtkCellArray.h>
#include <vtkIdTypeArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkVersionMacros.h>

#include <string>

namespace isostrata {

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 4, 0)
/// A cell array of faces, and another that says which faces a cell has; offsets were checked.
void VtkPolyhedra::read(vtkIdType c, PolyhedronFaces& to) {
  vtkCellArray* const faces = grid_->GetPolyhedronFaces();
  vtkCellArray* const of_cells = grid_->GetPolyhedronFaceLocations();
  const vtkIdType count = faces ? faces->GetNumberOfCells() : 0;
  to.clear();
  if (!of_cells || c >= of_cells->GetNumberOfCells()) checks_.broken("there are no faces of polyhedron " + std::to_string(c));
  of_cells->GetCellAtId(c, face_ids_);
  for (vtkIdType f = 0; f < face_ids_->GetNumberOfIds(); ++f) {
    const vtkIdType face = face_ids_->GetId(f);
    if (face < 0 || face >= count)
      checks_.broken("face " + std::to_string(f) + " of polyhedron " + std::to_string(c) + " is number " + std::to_string(face) +
                     " of " + std::to_string(count));
    faces->GetCellAtId(face, corners_);
    cycle_.clear();
    for (vtkIdType v = 0; v < corners_->GetNumberOfIds(); ++v) cycle_.push_back(checks_.point(c, corners_->GetId(v)));
    to.add(cycle_);
  }
}

void VtkPolyhedra::check() const {
  if (vtkCellArray* faces = grid_->GetPolyhedronFaces()) checks_.offsets(faces, "face");
  if (vtkCellArray* of_cells = grid_->GetPolyhedronFaceLocations()) checks_.offsets(of_cells, "polyhedron");
}
#else
/// GetFaceStream trusts the locations and counts in the file, so they are read here.
void VtkPolyhedra::read(vtkIdType c, PolyhedronFaces& to) {
  vtkIdTypeArray* stream = grid_->GetFaces();
  vtkIdTypeArray* locations = grid_->GetFaceLocations();
  const vtkIdType size = stream ? stream->GetNumberOfValues() : 0;
  vtkIdType at = locations && c < locations->GetNumberOfValues() ? locations->GetValue(c) : -1;
  const auto next = [&]() -> vtkIdType {
    if (at < 0 || at >= size)
      checks_.broken("the faces of polyhedron " + std::to_string(c) + " leave the " + std::to_string(size) + " face entries there are");
    return stream->GetValue(at++);
  };
  to.clear();
  const vtkIdType faces = next();
  if (faces < 0 || faces > size) checks_.broken("polyhedron " + std::to_string(c) + " has " + std::to_string(faces) + " faces");
  for (vtkIdType f = 0; f < faces; ++f) {
    const vtkIdType n = next();
    if (n < 0 || n > size - at)
      checks_.broken("face " + std::to_string(f) + " of polyhedron " + std::to_string(c) + " has " + std::to_string(n) + " points");
    cycle_.clear();
    for (vtkIdType v = 0; v < n; ++v) cycle_.push_back(checks_.point(c, next()));
    to.add(cycle_);
  }
}

void VtkPolyhedra::check() const {}
#endif

}  // namespace isostrata
