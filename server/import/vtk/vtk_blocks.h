// From VTK's datasets to ours.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "import/imported/imported.h"

class vtkDataObject;

namespace isostrata {

/// Appends one block for each dataset in `object` that holds points: image, rectilinear, structured or unstructured; composites
/// are walked. Arrays are shared with VTK where its memory layout allows. Cells become the four 3-D kinds as vtk_cells.h says;
/// others are left out and counted in notes. Cells that vtkGhostType hides are marked hidden; `joined_pieces` says that a
/// structured grid was put together from pieces, so that marks of duplicated cells mean nothing. Throws unsupported for polygonal
/// data and tables, bad_data for cells whose points are not there.
void append_vtk_blocks(vtkDataObject* object, const ReadRequest& request, bool joined_pieces, std::vector<Block>& blocks,
                       std::vector<std::string>& notes);

}  // namespace isostrata
