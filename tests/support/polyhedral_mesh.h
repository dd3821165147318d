// Polyhedral meshes that tests make.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include "base/vec.h"
#include "data/grids/grid.h"
#include "tables/cell_type.h"

namespace isostrata::test {

struct PolyhedralMesh {
  std::vector<Vec3d> points;
  std::vector<std::vector<std::vector<std::int64_t>>> cells;  // [cells][faces] cycles of point ids
  double volume = 0;
};

/// Other numbers for its points.
inline void number_at_random(PolyhedralMesh& mesh, std::mt19937_64& random) {
  std::vector<std::int64_t> numbers(mesh.points.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  std::shuffle(numbers.begin(), numbers.end(), random);
  std::vector<Vec3d> moved(mesh.points.size());
  for (std::size_t p = 0; p < moved.size(); ++p) moved[static_cast<std::size_t>(numbers[p])] = mesh.points[p];
  mesh.points = std::move(moved);
  for (auto& cell : mesh.cells)
    for (auto& face : cell)
      for (auto& id : face) id = numbers[static_cast<std::size_t>(id)];
}

}  // namespace isostrata::test
