// From VTK's datasets to ours.
#pragma once

#include <string>
#include <vector>

#include "import/imported.h"

class vtkDataObject;

namespace isostrata {

/// Appends one block for each dataset in `object` that holds points: image, rectilinear, structured or unstructured; composites
/// are walked. Arrays are shared with VTK where its memory layout allows. Cells other than the four 3-D kinds are left out and
/// counted in notes; quadratic and higher-order ones are kept by their corners. Throws unsupported for polygonal data and tables,
/// bad_data for cells whose points are not there.
void append_vtk_blocks(vtkDataObject* object, const ReadRequest& request, std::vector<Block>& blocks,
                       std::vector<std::string>& notes);

}  // namespace isostrata
