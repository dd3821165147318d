#include "extraction/gradient_normals.h"

#include <atomic>
#include <cmath>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr std::int64_t kGrain = 4096;

Vec3d unit_or_zero(Vec3d v) {
  const double size = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});  // squares of tiny gradients would be 0
  if (!(size > 0) || !std::isfinite(size)) return {};
  return normalized(v / size);
}

/// The gradient at points of a structured grid, up to the factor that all of it shares.
template <class T>
class StructuredGradient {
 public:
  StructuredGradient(const Grid& grid, std::span<const T> values) : grid_(grid), values_(values), dims_(grid.dims()) {}

  Vec3d at(std::int64_t point) const {
    const std::int64_t strides[3] = {1, dims_[0], dims_[0] * dims_[1]};
    const std::int64_t index[3] = {point % dims_[0], point / dims_[0] % dims_[1], point / strides[2]};
    Vec3d along[3];  // the grid's points and the field per step of each index
    double rise[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::int64_t before = index[axis] > 0 ? point - strides[axis] : point;
      std::int64_t after = index[axis] + 1 < dims_[axis] ? point + strides[axis] : point;
      if (!std::isfinite(value(before))) before = point;
      if (!std::isfinite(value(after))) after = point;
      const double steps = after == before ? 1 : static_cast<double>((after - before) / strides[axis]);
      along[axis] = (grid_.point(after) - grid_.point(before)) / steps;
      rise[axis] = (value(after) - value(before)) / steps;
    }
    // The rows of the inverse Jacobian are cross products over its determinant.
    const Vec3d across[3] = {cross(along[1], along[2]), cross(along[2], along[0]), cross(along[0], along[1])};
    const double volume = dot(along[0], across[0]);
    if (!(std::abs(volume) > 1e-9 * length(along[0]) * length(along[1]) * length(along[2]))) return {};
    return (across[0] * rise[0] + across[1] * rise[1] + across[2] * rise[2]) / volume;
  }

 private:
  double value(std::int64_t point) const { return static_cast<double>(values_[static_cast<std::size_t>(point)]); }

  const Grid& grid_;
  std::span<const T> values_;
  std::array<std::int64_t, 3> dims_;
};

/// The direction of the linear field that fits the cell's values best, or zero.
template <class T>
Vec3d cell_direction(const Grid& grid, std::span<const T> values, const std::int64_t* ids, int count) {
  Vec3d at[kMaxCellVertices], center;
  double value[kMaxCellVertices], mean = 0;
  for (int v = 0; v < count; ++v) {
    at[v] = grid.point(ids[v]);
    value[v] = static_cast<double>(values[static_cast<std::size_t>(ids[v])]);
    center = center + at[v];
    mean += value[v];
  }
  center = center / static_cast<double>(count);
  mean /= count;
  double a[6] = {}, size = 0;  // xx xy xz yy yz zz
  Vec3d b;
  for (int v = 0; v < count; ++v) {
    const Vec3d d = at[v] - center;
    a[0] += d.x * d.x, a[1] += d.x * d.y, a[2] += d.x * d.z, a[3] += d.y * d.y, a[4] += d.y * d.z, a[5] += d.z * d.z;
    b = b + d * (value[v] - mean);
    size += dot(d, d);
  }
  const Vec3d row0{a[0], a[1], a[2]}, row1{a[1], a[3], a[4]}, row2{a[2], a[4], a[5]};
  const Vec3d inverse0 = cross(row1, row2), inverse1 = cross(row2, row0), inverse2 = cross(row0, row1);
  if (!(dot(row0, inverse0) > 1e-12 * size * size * size)) return {};  // flat
  return unit_or_zero({dot(inverse0, b), dot(inverse1, b), dot(inverse2, b)});
}

/// Means over cells, added as whole numbers: sums of those do not depend on their order.
class UnstructuredGradient {
 public:
  template <class T>
  UnstructuredGradient(const Grid& grid, std::span<const T> values, const IntervalMesh& mesh, const Task& task)
      : used_(static_cast<std::size_t>(grid.point_count()), 0), sums_(used_.size()) {
    for (const PointOrigin& origin : mesh.origins)
      used_[static_cast<std::size_t>(origin.a())] = used_[static_cast<std::size_t>(origin.b())] = 1;
    for (const std::int64_t point : mesh.inner.points) used_[static_cast<std::size_t>(point)] = 1;
    parallel_for(grid.cell_count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
      task.check();
      std::array<std::int64_t, kMaxCellVertices> ids{};
      for (std::int64_t cell = begin; cell < end; ++cell) {
        if (grid.hidden(cell)) continue;
        const int count = grid.cell_points(cell, ids);
        bool used = false;
        for (int v = 0; v < count; ++v) used = used || used_[static_cast<std::size_t>(ids[static_cast<std::size_t>(v)])];
        if (!used) continue;
        const Vec3d direction = cell_direction(grid, values, ids.data(), count);
        for (int v = 0; v < count; ++v)
          for (int axis = 0; axis < 3; ++axis)
            std::atomic_ref(sums_[static_cast<std::size_t>(ids[static_cast<std::size_t>(v)])][axis])
                .fetch_add(static_cast<std::int32_t>(std::lround(direction[axis] * kOne)), std::memory_order_relaxed);
      }
    });
  }

  Vec3d at(std::int64_t point) const {
    const auto& sum = sums_[static_cast<std::size_t>(point)];
    return {static_cast<double>(sum.x), static_cast<double>(sum.y), static_cast<double>(sum.z)};
  }

 private:
  static constexpr double kOne = 1 << 18;  // 4096 cells at a point fit; beyond, shading may be wrong there

  std::vector<std::uint8_t> used_;        // [np]
  std::vector<Vec3<std::int32_t>> sums_;  // [np]
};

template <class Gradient>
std::vector<Vec3f> carry(const Gradient& gradient, const IntervalMesh& mesh, const Task& task) {
  std::vector<Vec3f> normals(mesh.positions.size());
  const auto store = [&](std::size_t to, Vec3d n) {
    n = unit_or_zero(n);
    normals[to] = {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
  };
  parallel_for(static_cast<std::int64_t>(mesh.origins.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const PointOrigin& origin = mesh.origins[i];
      // Directions, not gradients: beside a steep cell a gradient would outweigh its neighbour whatever the weight.
      const Vec3d a = unit_or_zero(gradient.at(origin.a()));
      if (origin.a() == origin.b()) {
        store(i, a);
        continue;
      }
      const Vec3d b = unit_or_zero(gradient.at(origin.b()));
      const double weight = static_cast<double>(origin.weight());
      store(i, a == Vec3d{} ? b : b == Vec3d{} ? a : a * (1 - weight) + b * weight);
    }
  });
  for (std::size_t i = 0; i + 1 < mesh.inner.first.size(); ++i) {
    Vec3d sum;
    for (std::uint32_t k = mesh.inner.first[i]; k < mesh.inner.first[i + 1]; ++k)
      sum = sum + unit_or_zero(gradient.at(mesh.inner.points[k])) * static_cast<double>(mesh.inner.weights[k]);
    store(mesh.origins.size() + i, sum);
  }
  return normals;
}

}  // namespace

std::vector<Vec3f> gradient_normals(const Grid& grid, const PointArray& array, const IntervalMesh& mesh, const Task& task) {
  if (mesh.origins.size() + mesh.inner.first.size() - 1 != mesh.positions.size()) return {};
  return std::visit(
      [&](auto values) {
        if (grid.structured()) return carry(StructuredGradient(grid, values), mesh, task);
        return carry(UnstructuredGradient(grid, values, mesh, task), mesh, task);
      },
      array.values);
}

}  // namespace isostrata
