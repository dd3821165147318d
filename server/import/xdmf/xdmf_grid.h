// One Uniform grid of XDMF as VTK has it: topology and geometry, without arrays.
#pragma once

#include <vtkSmartPointer.h>

#include <memory>
#include <vector>

#include "import/xdmf/xdmf_values.h"

class vtkDataArray;
class vtkDataSet;
class vtkPoints;
class vtkUnstructuredGrid;

namespace isostrata {

/// Values that VTK's arrays lie in: they must outlive these.
using XdmfKept = std::vector<std::shared_ptr<const void>>;

/// As an array of VTK's over the same bytes.
vtkSmartPointer<vtkDataArray> vtk_array(const XdmfArray& array, int components, XdmfKept& keep);

/// The cells of an unstructured topology, over no points yet. Throws bad_data, unsupported.
vtkSmartPointer<vtkUnstructuredGrid> xdmf_cells(const XdmfElement& topology, XdmfFile& file, XdmfValues& values, const ReadRequest& request);

/// Image, rectilinear, structured or unstructured. Throws bad_data, unsupported.
vtkSmartPointer<vtkDataSet> xdmf_grid(const XdmfElement& topology, const XdmfElement& geometry, XdmfFile& file, XdmfValues& values, const ReadRequest& request, XdmfKept& keep);

}  // namespace isostrata
