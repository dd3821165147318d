#include "data/derived/sampled_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "base/buffer.h"
#include "base/finite.h"
#include "base/parallel.h"

namespace isostrata {
namespace {

/// The points of a uniform grid, and places in its steps from the first.
struct Lattice {
  std::array<std::int64_t, 3> dims{};
  Vec3d lower, spacing;

  Lattice(const Box3d& box, std::int64_t most_points) : lower(box.lower) {
    const Vec3d size = box.upper - box.lower;
    const double step = step_of(size, static_cast<double>(most_points));
    for (int a = 0; a < 3; ++a) {
      const double steps = std::max(1.0, std::floor(size[a] / step));
      dims[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(steps) + 1;
      spacing[a] = size[a] / steps;
    }
  }
  /// The same along all axes but those that are shorter: these have two points.
  static double step_of(Vec3d size, double most_points) {
    std::sort(&size.x, &size.x + 3);
    for (const int shortest : {0, 1}) {
      const double step = shortest == 0 ? std::cbrt(size.x * size.y * size.z / most_points) : std::sqrt(size.y * size.z / most_points);
      if (size[shortest] >= step) return step;
      most_points /= 2;
    }
    return size.z / most_points;
  }
  std::size_t size() const { return static_cast<std::size_t>(dims[0] * dims[1] * dims[2]); }
  Vec3d place(Vec3d world) const {
    const Vec3d from = world - lower;
    return {from.x / spacing.x, from.y / spacing.y, from.z / spacing.z};
  }
};

/// [points] A point belongs to some twenty cells.
Buffer<Vec3d> places_of(const Grid& grid, const Lattice& lattice, const Task& task) {
  Buffer<Vec3d> places(static_cast<std::size_t>(grid.point_count()));
  parallel_for(grid.point_count(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t id = begin; id < end; ++id) places[static_cast<std::size_t>(id)] = lattice.place(grid.point(id));
  });
  return places;
}

/// Lattice points of a box; empty: there is none.
struct Range {
  std::array<std::int64_t, 3> first{}, last{};
  bool empty = false;

  Range(std::span<const Vec3d> corners, const Lattice& lattice, double beyond) {
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      double low = corners[0][a], high = low;
      for (const Vec3d& corner : corners.subspan(1)) low = std::min(low, corner[a]), high = std::max(high, corner[a]);
      const double more = beyond * (high - low);
      if (!(low - more <= static_cast<double>(lattice.dims[axis]) && high + more >= 0)) {  // NaN, too
        empty = true;
        return;
      }
      const double from = std::max(0.0, low - more);
      first[axis] = static_cast<std::int64_t>(from);
      first[axis] += static_cast<double>(first[axis]) < from;
      last[axis] = static_cast<std::int64_t>(std::min(high + more, static_cast<double>(lattice.dims[axis] - 1)));
      empty = empty || last[axis] < first[axis];
    }
  }
};

using Four = std::array<std::uint8_t, 4>;

/// VTK's corners of the tetrahedra that a cell is taken for. Neighbours may cut a face that is not flat in two ways, so pieces reach a little beyond.
std::span<const Four> tetrahedra_of(CellType type) {
  static constexpr Four kTetrahedron[] = {{0, 1, 2, 3}}, kPyramid[] = {{0, 1, 2, 4}, {0, 2, 3, 4}}, kWedge[] = {{0, 1, 2, 5}, {0, 1, 5, 4}, {0, 4, 5, 3}},
                        kHexahedron[] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  switch (type) {
    case CellType::tetrahedron:
      return kTetrahedron;
    case CellType::pyramid:
      return kPyramid;
    case CellType::wedge:
      return kWedge;
    case CellType::hexahedron:
      return kHexahedron;
    default:
      return {};
  }
}
constexpr double kBeyondTetrahedron = 1e-6, kBeyondPiece = 0.02;  // barycentric: -kBeyond is inside

/// visit(point, weights of the corners) for the lattice points in a tetrahedron.
template <class Visit>
void visit_inside(const std::array<Vec3d, 4>& p, const Lattice& lattice, double beyond, const Visit& visit) {
  const Range range(p, lattice, beyond);
  if (range.empty) return;
  const Vec3d u = p[1] - p[0], v = p[2] - p[0], w = p[3] - p[0];
  const Vec3d vw = cross(v, w), wu = cross(w, u), uv = cross(u, v);
  const double volume = dot(u, vw);
  if (!(std::abs(volume) > 0)) return;
  const double share = 1 / volume;
  for (std::int64_t k = range.first[2]; k <= range.last[2]; ++k)
    for (std::int64_t j = range.first[1]; j <= range.last[1]; ++j)
      for (std::int64_t i = range.first[0]; i <= range.last[0]; ++i) {
        const Vec3d d = Vec3d{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)} - p[0];
        const double b = dot(d, vw) * share, c = dot(d, wu) * share, e = dot(d, uv) * share, a = 1 - b - c - e;
        if (std::min({a, b, c, e}) >= -beyond) visit(static_cast<std::size_t>(i + lattice.dims[0] * (j + lattice.dims[1] * k)), std::array{a, b, c, e});
      }
}

/// An array that is being filled. Where cells meet, the larger value stays, whoever comes first.
struct Filled {
  const PointArray* from = nullptr;
  std::shared_ptr<float[]> single;  // one of the two
  std::shared_ptr<double[]> wide;   // of types that single precision does not hold

  Filled(const PointArray& array, std::size_t size) : from(&array) {
    const bool narrow = array.type == ScalarType::float32 || size_of(array.type) <= 2;
    const auto nowhere = [&](auto& values, auto none) {
      values = std::shared_ptr<decltype(none)[]>(new decltype(none)[size]);
      std::fill_n(values.get(), size, none);
    };
    if (narrow)
      nowhere(single, std::numeric_limits<float>::quiet_NaN());
    else
      nowhere(wide, std::numeric_limits<double>::quiet_NaN());
  }
  void put(std::size_t at, double value) const {
    if (!std::isfinite(value)) return;
    const auto raise = [&](auto& slot, auto to) {
      const std::atomic_ref own(slot);
      for (auto before = own.load(std::memory_order_relaxed); !(before >= to) && !own.compare_exchange_weak(before, to, std::memory_order_relaxed);) {
      }
    };
    if (single)
      raise(single[static_cast<std::ptrdiff_t>(at)], static_cast<float>(value));
    else
      raise(wide[static_cast<std::ptrdiff_t>(at)], value);
  }
  PointArray finish(std::size_t size) const {
    PointArray array;
    array.name = from->name;
    array.components = from->components;
    array.component = from->component;
    array.unit = from->unit;
    array.type = single ? ScalarType::float32 : ScalarType::float64;
    if (single)
      array.values = std::span<const float>(single.get(), size), array.storage = single;
    else
      array.values = std::span<const double>(wide.get(), size), array.storage = wide;
    measure_range(array);
    array.lower = from->lower;
    array.upper = from->upper;
    return array;
  }
};

}  // namespace

bool can_be_sampled(const Dataset& mesh) {
  const Vec3d size = mesh.bounds.upper - mesh.bounds.lower;
  return !mesh.grid.structured() && mesh.grid.cell_count() > 0 && !mesh.grid.flat() && !mesh.bounds.empty() && is_finite(mesh.bounds.lower) &&
         is_finite(mesh.bounds.upper) && std::min({size.x, size.y, size.z}) > 1e-6 * std::max({size.x, size.y, size.z});
}

std::shared_ptr<const Dataset> sampled(const Dataset& mesh, std::int64_t most_points, std::span<const std::string> arrays, const Task& task) {
  const Lattice lattice(mesh.bounds, most_points);
  std::vector<Filled> filled;
  for (const std::string& name : arrays) filled.emplace_back(mesh.array(name), lattice.size());
  const Grid& grid = mesh.grid;
  const Buffer<Vec3d> place_of = places_of(grid, lattice, task);
  parallel_for(grid.cell_count(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    std::array<std::int64_t, kMaxCellVertices> ids;
    std::array<Vec3d, kMaxCellVertices> places;
    for (std::int64_t cell = begin; cell < end; ++cell) {
      if (grid.hidden(cell)) continue;
      const auto corners = static_cast<std::size_t>(grid.cell_points(cell, ids));
      for (std::size_t v = 0; v < corners; ++v) places[v] = place_of[static_cast<std::size_t>(ids[v])];
      const auto pieces = tetrahedra_of(grid.cell_type(cell));
      const double beyond = pieces.size() == 1 ? kBeyondTetrahedron : kBeyondPiece;
      if (pieces.size() > 1 && Range(std::span(places).first(corners), lattice, beyond).empty) continue;
      for (const Four& of : pieces)
        visit_inside({places[of[0]], places[of[1]], places[of[2]], places[of[3]]}, lattice, beyond, [&](std::size_t at, const std::array<double, 4>& weights) {
          for (const Filled& array : filled) {
            double value = 0;
            for (std::size_t v = 0; v < 4; ++v) value += weights[v] * array.from->at(static_cast<std::size_t>(ids[of[v]]));
            array.put(at, value);
          }
        });
    }
  });
  auto out = std::make_shared<Dataset>();
  out->name = mesh.name;
  out->times = mesh.times;
  out->step = mesh.step;
  UniformGrid shape;
  shape.dims = lattice.dims;
  for (int a = 0; a < 3; ++a) shape.origin[a] = lattice.lower[a], shape.spacing[a] = lattice.spacing[a];
  out->grid.shape = shape;
  out->bounds = mesh.bounds;
  out->cell_types = {{"hexahedron", out->grid.cell_count()}};
  for (const Filled& array : filled) out->arrays.push_back(array.finish(lattice.size()));
  return out;
}

}  // namespace isostrata
