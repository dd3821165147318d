#include "extraction/surfaces/gradient_normals.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/parallel.h"
#include "extraction/surfaces/blend_directions.h"
#include "extraction/surfaces/interval_surfaces.h"

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
template <class Place, class Value>
Vec3d cell_direction(const Place& place, const Value& value_at, int count) {
  Vec3d at[kMaxCellVertices], center;
  double value[kMaxCellVertices], mean = 0;
  for (int v = 0; v < count; ++v) {
    at[v] = place(v);
    value[v] = value_at(v);
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

/// Means over cells are added as whole numbers: sums of those do not depend on their order.
void add(Vec3<std::int32_t>& sum, Vec3d direction) {
  constexpr double kOne = 1 << 18;  // 4096 cells at a point fit; beyond, shading may be wrong there
  for (int axis = 0; axis < 3; ++axis)
    std::atomic_ref(sum[axis]).fetch_add(static_cast<std::int32_t>(std::lround(direction[axis] * kOne)),
                                         std::memory_order_relaxed);
}

Vec3f single_unit(Vec3d v) {
  const Vec3d n = unit_or_zero(v);
  return {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)};
}

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
        const auto id = [&](int v) { return ids[static_cast<std::size_t>(v)]; };
        const Vec3d direction =
            cell_direction([&](int v) { return grid.point(id(v)); },
                           [&](int v) { return static_cast<double>(values[static_cast<std::size_t>(id(v))]); }, count);
        for (int v = 0; v < count; ++v) add(sums_[static_cast<std::size_t>(id(v))], direction);
      }
    });
  }

  Vec3d at(std::int64_t point) const {
    const auto& sum = sums_[static_cast<std::size_t>(point)];
    return {static_cast<double>(sum.x), static_cast<double>(sum.y), static_cast<double>(sum.z)};
  }

 private:
  std::vector<std::uint8_t> used_;        // [np]
  std::vector<Vec3<std::int32_t>> sums_;  // [np]
};

/// Where normals are looked up.
Buffer<std::uint8_t> points_in_use(const IntervalMesh& mesh, NormalsAt at) {
  const bool all = at == NormalsAt::all_points || mesh.facets.empty();
  const std::size_t np = mesh.positions.size();
  Buffer<std::uint8_t> used(np);
  parallel_for(static_cast<std::int64_t>(np), 1 << 17, [&](std::int64_t begin, std::int64_t end) {
    std::fill(used.begin() + begin, used.begin() + end, std::uint8_t{all});
  });
  if (all) return used;
  parallel_for(static_cast<std::int64_t>(mesh.facets.size()), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    for (auto f = static_cast<std::size_t>(begin); f < static_cast<std::size_t>(end); ++f)
      for (const std::uint32_t point : mesh.facets[f].points) std::atomic_ref(used[point]).store(1, std::memory_order_relaxed);
  });
  return used;
}

/// The gradient at inner points of a grid of boxes, for vectors; what it says no to is left to StructuredGradient.
template <class T>
class BoxGradient {
 public:
  BoxGradient(const Grid& grid, std::span<const T> values) : values_(values.data()), dims_(grid.dims()) {
    stride_ = {1, dims_[0], dims_[0] * dims_[1]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto place = [&](std::int64_t i) { return grid.point(i * stride_[axis])[static_cast<int>(axis)]; };
      inverse_[axis].assign(static_cast<std::size_t>(dims_[axis]), 0);
      for (std::int64_t i = 1; i + 1 < dims_[axis]; ++i)
        inverse_[axis][static_cast<std::size_t>(i)] = static_cast<float>(1 / (place(i + 1) - place(i - 1)));
    }
  }

  bool put(const PointOrigin& origin, std::size_t lane, DirectionBatch& to) const {
    const std::int64_t a = origin.a(), step = origin.b() - a;
    std::array<std::int64_t, 3> index{};
    if (a <= std::numeric_limits<std::uint32_t>::max()) {  // a shorter division
      const auto p = static_cast<std::uint32_t>(a), row = p / static_cast<std::uint32_t>(dims_[0]);
      index = {p - row * static_cast<std::uint32_t>(dims_[0]), row % static_cast<std::uint32_t>(dims_[1]),
               row / static_cast<std::uint32_t>(dims_[1])};
    } else {
      index = {a % dims_[0], a / dims_[0] % dims_[1], a / stride_[2]};
    }
    if (!gradient(a, index, lane, to.at_a)) return false;
    to.weight[lane] = origin.weight();
    if (step == 0) return gradient(a, index, lane, to.at_b);
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (step == stride_[axis]) {
        ++index[axis];
        return gradient(a + step, index, lane, to.at_b);
      }
    return false;  // a seam
  }

 private:
  bool gradient(std::int64_t point, const std::array<std::int64_t, 3>& index, std::size_t lane,
                float (&to)[3][DirectionBatch::kSize]) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (index[axis] < 1 || index[axis] + 1 >= dims_[axis]) return false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      to[axis][lane] = rise(values_[point + stride_[axis]], values_[point - stride_[axis]]) *
                       inverse_[axis][static_cast<std::size_t>(index[axis])];
    return true;
  }
  static float rise(T after, T before) {
    if constexpr (std::is_same_v<T, float>)
      return after - before;
    else
      return static_cast<float>(static_cast<double>(after) - static_cast<double>(before));
  }

  const T* values_;
  std::array<std::int64_t, 3> dims_, stride_;
  std::array<std::vector<float>, 3> inverse_;  // of what lies between the neighbours
};

struct NoBoxes {
  bool put(const PointOrigin&, std::size_t, DirectionBatch&) const { return false; }
};

/// One after the other of those that are used: `boxes` has the first try.
template <class Gradient, class Boxes>
std::vector<Vec3f> carry(const Gradient& gradient, const Boxes& boxes, const IntervalMesh& mesh, NormalsAt at, const Task& task) {
  std::vector<Vec3f> normals(mesh.positions.size());
  const Buffer<std::uint8_t> used = points_in_use(mesh, at);
  const auto store = [&](std::size_t to, Vec3d n) { normals[to] = single_unit(n); };
  const auto carry_one = [&](std::size_t i) {
    const PointOrigin& origin = mesh.origins[i];
    // Directions, not gradients: beside a steep cell a gradient would outweigh its neighbour whatever the weight.
    const Vec3d a = unit_or_zero(gradient.at(origin.a()));
    if (origin.a() == origin.b()) {
      store(i, a);
      return;
    }
    const Vec3d b = unit_or_zero(gradient.at(origin.b()));
    const double weight = static_cast<double>(origin.weight());
    store(i, a == Vec3d{} ? b : b == Vec3d{} ? a : a * (1 - weight) + b * weight);
  };
  parallel_for(static_cast<std::int64_t>(mesh.origins.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    DirectionBatch batch;
    std::array<std::size_t, DirectionBatch::kSize> points{};
    std::size_t held = 0;
    const auto blend = [&] {
      blend_directions(batch, held);
      for (std::size_t k = 0; k < held; ++k) {
        if (batch.sure[k])
          normals[points[k]] = batch.direction[k];
        else
          carry_one(points[k]);
      }
      held = 0;
    };
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      if (!used[i]) {
        normals[i] = {};
        continue;
      }
      if (!boxes.put(mesh.origins[i], held, batch)) {
        carry_one(i);
        continue;
      }
      points[held] = i;
      if (++held == DirectionBatch::kSize) blend();
    }
    blend();
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

std::vector<Vec3f> gradient_normals(const Grid& grid, const PointArray& array, const IntervalMesh& mesh, const Task& task,
                                    NormalsAt at) {
  if (mesh.origins.size() + mesh.inner.first.size() - 1 != mesh.positions.size()) return {};
  return std::visit(
      [&](auto values) {
        if (grid.rectilinear()) return carry(StructuredGradient(grid, values), BoxGradient(grid, values), mesh, at, task);
        if (grid.structured()) return carry(StructuredGradient(grid, values), NoBoxes{}, mesh, at, task);
        return carry(UnstructuredGradient(grid, values, mesh, task), NoBoxes{}, mesh, at, task);
      },
      array.values);
}

std::vector<Vec3f> point_directions(const BaseTetrahedra& base) {
  const IntervalMesh& mesh = *base.mesh;
  std::vector<Vec3<std::int32_t>> sums(mesh.positions.size());
  parallel_for(static_cast<std::int64_t>(mesh.tetrahedra.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      const auto& ids = mesh.tetrahedra[t];
      const Vec3d direction = cell_direction([&](int v) { return mesh.positions[ids[static_cast<std::size_t>(v)]]; },
                                             [&](int v) { return double{(*base.values)[ids[static_cast<std::size_t>(v)]]}; }, 4);
      for (const std::uint32_t id : ids) add(sums[id], direction);
    }
  });
  std::vector<Vec3f> directions(sums.size());
  parallel_for(static_cast<std::int64_t>(sums.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p)
      directions[p] =
          single_unit({static_cast<double>(sums[p].x), static_cast<double>(sums[p].y), static_cast<double>(sums[p].z)});
  });
  return directions;
}

}  // namespace isostrata
