// Two steps of a small grid with values in memory, for tests of time.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "data/dataset/analytic.h"
#include "data/dataset/dataset.h"
#include "extraction/small_grids.h"
#include "extraction/space_time/space_time_cells.h"

namespace isostrata {

struct Series {
  std::vector<std::shared_ptr<const Dataset>> steps;
};

inline std::shared_ptr<const Dataset> analytic(std::string_view name) {
  const Task task;
  return make_analytic(name, {}, task);
}

/// Steps at the times 10, 20, ... with these arrays.
inline Series series_of(const Grid& grid, std::vector<PointArray> arrays) {
  Series series;
  std::vector<double> times;
  for (std::size_t i = 0; i < arrays.size(); ++i) times.push_back(10.0 * static_cast<double>(i + 1));
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    auto dataset = std::make_shared<Dataset>();
    dataset->name = "series";
    dataset->grid = grid;
    dataset->bounds = grid.bounds();
    dataset->arrays.push_back(arrays[i]);
    measure_range(dataset->arrays.back());
    dataset->times = times;
    dataset->step = static_cast<int>(i);
    series.steps.push_back(dataset);
  }
  return series;
}

inline Series series_of(const Grid& grid, PointArray first, PointArray second) {
  return series_of(grid, std::vector<PointArray>{std::move(first), std::move(second)});
}

/// Two steps of random values in [0, 1].
inline Series random_series(const Grid& grid, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  auto first = point_array(random_values(grid.point_count(), 0, 1, random));
  return series_of(grid, std::move(first), point_array(random_values(grid.point_count(), 0, 1, random)));
}

/// Structured grids, meshes of each kind of cell and of all of them, numbered at random.
inline std::vector<std::pair<std::string, Grid>> grids_of_every_kind(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::pair<std::string, Grid>> out;
  out.emplace_back("uniform", uniform_grid({4, 3, 5}, {-1, 2, 0.5}, {0.5, 0.25, 2}));
  const auto shuffled = [&](const Grid& grid) {
    return unstructured_grid(as_parts(grid, random_numbers(grid.point_count(), random)));
  };
  out.emplace_back("hexahedra", shuffled(uniform_grid({3, 4, 3})));
  out.emplace_back("tets:4", shuffled(analytic("tets:4")->grid));
  out.emplace_back("mixed:5", shuffled(analytic("mixed:5")->grid));
  std::vector<Vec3d> bent;
  std::uniform_real_distribution<double> uniform(-0.1, 0.1);
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 4; ++i) bent.push_back({i + uniform(random), j + uniform(random), k + uniform(random)});
  out.emplace_back("curvilinear", curvilinear_grid({4, 3, 4}, bent));
  return out;
}

/// The grid with every cell split as space-time splits it.
inline Grid split_cells(const Grid& grid) {
  UnstructuredParts parts = as_parts(grid);
  UnstructuredParts split;
  split.points = parts.points;
  CellSplit cell(grid);
  for (std::int64_t c = 0; c < grid.cell_count(); ++c) {
    cell.begin_cell(c);
    for (const SplitTetrahedron& t : cell.tetrahedra()) {
      std::vector<std::int64_t> ids;
      for (const std::uint8_t v : t.vertex) ids.push_back(cell.ids()[v]);
      if (t.turned) std::swap(ids[0], ids[1]);
      split.add(CellType::tetrahedron, ids);
    }
  }
  return unstructured_grid(split);
}

}  // namespace isostrata
