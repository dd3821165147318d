// Cells by their outlines on a map, in one layer or several: areas, or prisms.
#pragma once

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "import/imported/imported.h"

namespace isostrata {

/// Around each cell, and where these points are.
struct Outlines {
  std::vector<std::vector<std::int64_t>> of_cells;
  std::vector<std::array<double, 2>> points;
};

/// The ends of each level: the middles between two of them, and as far beyond the first and the last. Of one level, that.
std::vector<double> ends_of_levels(const std::vector<double>& levels);

struct Prisms {
  vtkSmartPointer<vtkUnstructuredGrid> grid;
  std::vector<std::pair<std::size_t, std::size_t>> kept;  // of each of its cells the layer and the outline
  std::size_t left_out = 0;                               // of fewer than three corners, or more than six in a prism
};

/// Points at each of `heights`, cells between them; areas if there is one. Throws too_large.
Prisms prisms_of(const Outlines& outlines, const std::vector<double>& heights, const ReadRequest& request);

/// Of values [layer][place], or [place][layer] if places are first, those of the given layers and places.
vtkSmartPointer<vtkDataArray> taken(vtkDataArray& values, const std::vector<std::pair<std::size_t, std::size_t>>& which, std::size_t layers, std::size_t places, bool places_first);

}  // namespace isostrata
