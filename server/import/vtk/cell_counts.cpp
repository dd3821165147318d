#include "import/vtk/cell_counts.h"

#include <vtkCellTypes.h>

namespace isostrata {

/// "VTK_QUADRATIC_TETRA" is what people search for; VTK calls it "vtkQuadraticTetra".
std::string vtk_name(int type) {
  const char* name = vtkCellTypes::GetClassNameFromTypeId(type);
  return name && std::string(name) != "UnknownClass" ? name : "type " + std::to_string(type);
}

void CellCounts::note(bool flat, std::vector<std::string>& notes) const {
  const auto say = [&](std::int64_t n, const std::string& what) { notes.push_back(std::to_string(n) + " " + what); };
  for (const auto& [type, n] : skipped)
    say(n,
        vtk_name(type) +
            (flat
                 ? " skipped: only cells with an area or a volume are read"
                 : " skipped: only tetrahedra, pyramids, wedges, hexahedra, prisms, polyhedra and small convex point sets are "
                   "read"));
  for (const auto& [type, row] : fans)
    say(row.cells, vtk_name(type) + " read as " + std::to_string(row.pieces) + " triangles");
  for (const auto& [type, n] : open) say(n, vtk_name(type) + " skipped: their faces do not close up");
  for (const auto& [type, n] : linearised) say(n, vtk_name(type) + " read as linear cells by their corners");
  for (const auto& [type, row] : divided)
    say(row.cells, vtk_name(type) + " divided into " + std::to_string(row.pieces) + " linear cells between their nodes");
  for (const auto& [type, n] : whole)
    say(n, vtk_name(type) + " kept whole: they are tetrahedra, pyramids, wedges or hexahedra");
  for (const auto& [type, row] : split)
    say(row.cells, vtk_name(type) + " split into " + std::to_string(row.pieces) +
                       " tetrahedra and pyramids, each about a point added inside it, which has the mean of the cell's values");
  if (overlapping > 0)
    say(overlapping,
        "vtkPolyhedron have no point that sees all of their faces: their pieces overlap and volumes are too large");
}

}  // namespace isostrata
