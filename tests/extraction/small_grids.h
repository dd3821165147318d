// Small grids that own their points, for tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "extraction/cells/cell_geometry.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();  // of bytes

/// An array over a copy of the values.
template <class T>
PointArray point_array(const std::vector<T>& values, std::string name = "f") {
  auto storage = std::make_shared<std::vector<T>>(values);
  PointArray array;
  array.name = std::move(name);
  array.values = std::span<const T>(*storage);
  array.storage = storage;
  return array;
}

inline Grid uniform_grid(std::array<std::int64_t, 3> dims, Vec3d origin = {}, Vec3d spacing = {1, 1, 1}) {
  return {UniformGrid{dims, origin, spacing}, {}, nullptr};
}

struct UnstructuredParts {
  std::vector<Vec3d> points;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int64_t> connectivity;

  void add(CellType type, const std::vector<std::int64_t>& ids) {
    types.push_back(static_cast<std::uint8_t>(type));
    connectivity.insert(connectivity.end(), ids.begin(), ids.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
};

inline Grid unstructured_grid(UnstructuredParts parts) {
  auto storage = std::make_shared<UnstructuredParts>(std::move(parts));
  UnstructuredGrid shape;
  shape.points = std::span<const Vec3d>(storage->points);
  shape.types = storage->types;
  shape.offsets = storage->offsets;
  shape.connectivity = storage->connectivity;
  return {shape, {}, storage};
}

inline Grid curvilinear_grid(std::array<std::int64_t, 3> dims, std::vector<Vec3d> points) {
  auto storage = std::make_shared<std::vector<Vec3d>>(std::move(points));
  return {CurvilinearGrid{dims, std::span<const Vec3d>(*storage)}, {}, storage};
}

/// The grid as explicit cells; where `numbers` is given, point p gets the number numbers[p].
inline UnstructuredParts as_parts(const Grid& grid, const std::vector<std::int64_t>& numbers = {}) {
  UnstructuredParts parts;
  parts.points.resize(grid.point_count());
  for (std::int64_t p = 0; p < grid.point_count(); ++p) parts.points[numbers.empty() ? p : numbers[p]] = grid.point(p);
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::int64_t c = 0; c < grid.cell_count(); ++c) {
    const int n = grid.cell_points(c, ids);
    std::vector<std::int64_t> renumbered;
    for (int v = 0; v < n; ++v) renumbered.push_back(numbers.empty() ? ids[v] : numbers[ids[v]]);
    parts.add(grid.cell_type(c), renumbered);
  }
  return parts;
}

template <class T = double>
std::vector<T> random_values(std::int64_t count, double lower, double upper, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(lower, upper);
  std::vector<T> values(count);
  for (T& value : values) value = static_cast<T>(uniform(random));
  return values;
}

inline std::vector<std::int64_t> random_numbers(std::int64_t count, std::mt19937_64& random) {
  std::vector<std::int64_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0);
  std::shuffle(numbers.begin(), numbers.end(), random);
  return numbers;
}

/// Intervals between successive ends.
inline std::vector<Interval> tiling(std::vector<double> ends) {
  std::sort(ends.begin(), ends.end());
  std::vector<Interval> out;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) out.push_back({ends[i], ends[i + 1]});
  return out;
}

inline IntervalMesh extract(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals) {
  const Task task;
  ExtractOptions options;
  options.facets = true;
  return extract_intervals(grid, array, intervals, options, task);
}

inline double total_signed_volume(const IntervalMesh& mesh) {
  double sum = 0;
  for (const IntervalSummary& summary : mesh.summaries) sum += summary.signed_volume;
  return sum;
}

/// Sum of the cells' own volumes, each taken positive.
inline double grid_volume(const Grid& grid) {
  double sum = 0;
  std::array<std::int64_t, kMaxCellVertices> ids;
  std::array<Vec3d, kMaxCellVertices> points;
  for (std::int64_t c = 0; c < grid.cell_count(); ++c) {
    const int n = grid.cell_points(c, ids);
    for (int v = 0; v < n; ++v) points[v] = grid.point(ids[v]);
    sum += std::abs(signed_cell_volume(topology(grid.cell_type(c)), points.data()));
  }
  return sum;
}

inline std::int64_t unmatched(const IntervalMesh& mesh) {
  const Task task;
  return count_unmatched_facets(mesh, task);
}

inline std::int64_t count_label(const IntervalMesh& mesh, FacetLabel label) {
  return std::count_if(mesh.facets.begin(), mesh.facets.end(), [&](const BoundaryFacet& f) { return f.label == label; });
}

}  // namespace isostrata
