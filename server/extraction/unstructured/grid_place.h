// How an unstructured grid is known between extractions.
#pragma once

#include <variant>

#include "data/grids/grid.h"

namespace isostrata {

/// The same for as long as the grid is in memory; another one may lie there afterwards. Precondition: the grid is unstructured.
struct GridPlace {
  const void* connectivity = nullptr;
  const void* points = nullptr;
  const void* hidden = nullptr;

  static GridPlace of(const Grid& grid) {
    const auto& shape = std::get<UnstructuredGrid>(grid.shape);
    return {shape.connectivity.data(), std::visit([](auto points) { return static_cast<const void*>(points.data()); }, shape.points), grid.hidden_cells.data()};
  }
  bool operator==(const GridPlace&) const = default;
};

}  // namespace isostrata
