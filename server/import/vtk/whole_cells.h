// Cells of VTK's that are ours as they are, all arrays at once.
#pragma once

#include <cstdint>
#include <optional>

#include "import/vtk/vtk_cells.h"

class vtkCellArray;
class vtkUnsignedCharArray;

namespace isostrata {

/// Of tetrahedra, hexahedra, wedges and pyramids alone, as most files are. Numbers of 64 bits stay where VTK has them; those of 32 bits go as 64 into files of
/// the request's folder, a part at a time, and into no memory. Nothing: there are other cells, other arrays, or ids that are not points. Precondition: a type
/// for each cell, and offsets that do not fall.
std::optional<KeptCells> keep_whole_cells(vtkCellArray* cells, vtkUnsignedCharArray* types, std::int64_t points, const ReadRequest& request);

}  // namespace isostrata
