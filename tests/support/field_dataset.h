// Datasets of a formula, in memory: uniform grids, and meshes of any cells.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "data/dataset/dataset.h"

namespace isostrata::testing {

template <class T>
PointArray array_of(std::string name, std::vector<T> values) {
  auto held = std::make_shared<std::vector<T>>(std::move(values));
  PointArray array;
  array.name = std::move(name);
  array.values = std::span<const T>(*held);
  if constexpr (std::is_same_v<T, double>) array.type = ScalarType::float64;
  if constexpr (std::is_same_v<T, std::uint8_t>) array.type = ScalarType::uint8;
  if constexpr (std::is_same_v<T, std::int16_t>) array.type = ScalarType::int16;
  array.storage = held;
  measure_range(array);
  return array;
}

/// dims points over [-1, 1] along the longest side, with an array "value" of the field at each.
template <class T = float>
std::shared_ptr<Dataset> field_dataset(std::array<std::int64_t, 3> dims, const std::function<double(Vec3d)>& field) {
  auto dataset = std::make_shared<Dataset>();
  const double spacing = 2.0 / static_cast<double>(std::max({dims[0], dims[1], dims[2], std::int64_t{2}}) - 1);
  dataset->name = "field";
  dataset->grid.shape = UniformGrid{dims, {-1, -1, -1}, {spacing, spacing, spacing}};
  std::vector<T> values;
  for (std::int64_t id = 0; id < dataset->grid.point_count(); ++id)
    values.push_back(static_cast<T>(field(dataset->grid.point(id))));
  dataset->bounds = dataset->grid.bounds();
  dataset->arrays.push_back(array_of("value", std::move(values)));
  return dataset;
}

/// Owns what an unstructured grid looks at.
struct OwnedMesh {
  std::vector<Vec3d> points;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets{0}, connectivity;

  void add(CellType type, std::vector<std::int64_t> ids) {
    types.push_back(static_cast<std::uint8_t>(type));
    connectivity.insert(connectivity.end(), ids.begin(), ids.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
};

inline std::shared_ptr<Dataset> mesh_dataset(OwnedMesh mesh, const std::function<double(Vec3d)>& field) {
  auto held = std::make_shared<OwnedMesh>(std::move(mesh));
  auto dataset = std::make_shared<Dataset>();
  dataset->name = "mesh";
  dataset->grid.shape = UnstructuredGrid{std::span<const Vec3d>(held->points), held->types, held->offsets, held->connectivity};
  dataset->grid.storage = held;
  std::vector<float> values;
  for (const Vec3d& p : held->points) values.push_back(static_cast<float>(field(p)));
  dataset->bounds = dataset->grid.bounds();
  dataset->arrays.push_back(array_of("value", std::move(values)));
  return dataset;
}

}  // namespace isostrata::testing
