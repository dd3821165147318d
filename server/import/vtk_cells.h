// The 3-D cells of a vtkUnstructuredGrid.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

class vtkUnstructuredGrid;

namespace isostrata {

struct KeptCells {
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> source;  // [cells] the cell's number in the file; empty where every cell was kept
};

/// Checks every index before it is used, notes what was skipped or made linear. Throws bad_data.
KeptCells keep_cells(vtkUnstructuredGrid* grid, const std::string& name, std::vector<std::string>& notes);

}  // namespace isostrata
