// The cells of a grid of VTK's, given as lists.
#pragma once

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace isostrata {

/// types: VTK's; ends: [cells + 1] where in `ids` the nodes of each begin and the last one's end. No polyhedra.
inline void set_cells(vtkUnstructuredGrid* grid, const std::vector<std::uint8_t>& types, const std::vector<std::int64_t>& ends, const std::vector<std::int64_t>& ids) {
  const auto fill = [](auto* array, const auto& values) {
    array->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
    std::copy(values.begin(), values.end(), array->GetPointer(0));
  };
  vtkNew<vtkTypeInt64Array> all_ends, all_ids;
  vtkNew<vtkUnsignedCharArray> all_types;
  fill(all_ends.Get(), ends);
  fill(all_ids.Get(), ids);
  fill(all_types.Get(), types);
  vtkNew<vtkCellArray> cells;
  cells->SetData(all_ends, all_ids);
  grid->SetCells(all_types, cells);
}

}  // namespace isostrata
