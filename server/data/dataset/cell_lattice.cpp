#include "data/dataset/cell_lattice.h"

#include <array>
#include <memory>
#include <vector>

#include "base/parallel.h"

namespace isostrata {
namespace {

struct Cells {
  std::vector<Vec3f> points;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int64_t> connectivity;
  std::vector<float> values;

  void add(CellType type, std::initializer_list<std::int64_t> ids) {
    types.push_back(static_cast<std::uint8_t>(type));
    connectivity.insert(connectivity.end(), ids);
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
};

/// Corner (a,b,c) of a cube is number a + 2b + 4c. The six paths from corner 0 to corner 7, each with its middle two ordered so
/// that the tetrahedron is right-handed.
constexpr std::array<std::array<std::size_t, 4>, 6> kKuhn{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

/// -1 + 2i/(n-1), exactly 1 for the last point.
double coordinate(std::int64_t i, std::int64_t n) { return static_cast<double>(2 * i - (n - 1)) / static_cast<double>(n - 1); }

std::array<std::int64_t, 8> corners(std::int64_t i, std::int64_t j, std::int64_t k, std::int64_t n) {
  std::array<std::int64_t, 8> ids{};
  for (std::int64_t v = 0; v < 8; ++v)
    ids[static_cast<std::size_t>(v)] = i + (v & 1) + n * (j + ((v >> 1) & 1) + n * (k + (v >> 2)));
  return ids;
}

void fill_lattice_points(Cells& cells, std::int64_t n, double (*field)(Vec3d), const Task& task) {
  parallel_for(n * n, std::max<std::int64_t>(1, 4096 / n), [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t row = begin; row < end; ++row)
      for (std::int64_t i = 0; i < n; ++i) {
        const Vec3d p{coordinate(i, n), coordinate(row % n, n), coordinate(row / n, n)};
        const auto id = static_cast<std::size_t>(row * n + i);
        cells.points[id] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
        cells.values[id] = static_cast<float>(field(p));
      }
  });
}

void publish(Dataset& dataset, std::shared_ptr<const Cells> cells) {
  dataset.grid.shape = UnstructuredGrid{std::span<const Vec3f>(cells->points), cells->types, cells->offsets, cells->connectivity};
  dataset.grid.storage = cells;
  PointArray array;
  array.name = "distance";
  array.values = std::span<const float>(cells->values);
  array.storage = cells;
  dataset.arrays.push_back(std::move(array));
}

}  // namespace

std::uint64_t tets_bytes(std::int64_t n) {
  const auto points = static_cast<std::uint64_t>(n * n * n);
  const auto cells = 6 * static_cast<std::uint64_t>((n - 1) * (n - 1) * (n - 1));
  return points * (sizeof(Vec3f) + sizeof(float)) + cells * (1 + 5 * sizeof(std::int64_t)) + sizeof(std::int64_t);
}

void fill_tets(Dataset& dataset, std::int64_t n, double (*field)(Vec3d), const Task& task) {
  const auto cells = std::make_shared<Cells>();
  const std::int64_t points = n * n * n, side = n - 1, tetrahedra = 6 * side * side * side;
  cells->points.resize(static_cast<std::size_t>(points));
  cells->values.resize(static_cast<std::size_t>(points));
  cells->types.assign(static_cast<std::size_t>(tetrahedra), static_cast<std::uint8_t>(CellType::tetrahedron));
  cells->offsets.resize(static_cast<std::size_t>(tetrahedra) + 1);
  cells->connectivity.resize(static_cast<std::size_t>(tetrahedra) * 4);
  fill_lattice_points(*cells, n, field, task);
  parallel_for(side * side, std::max<std::int64_t>(1, 1024 / n), [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t row = begin; row < end; ++row)
      for (std::int64_t i = 0; i < side; ++i) {
        const auto cube = corners(i, row % side, row / side, n);
        for (std::size_t t = 0; t < 6; ++t) {
          const std::size_t cell = static_cast<std::size_t>(row * side + i) * 6 + t;
          cells->offsets[cell] = static_cast<std::int64_t>(4 * cell);
          for (std::size_t v = 0; v < 4; ++v) cells->connectivity[4 * cell + v] = cube[kKuhn[t][v]];
        }
      }
  });
  cells->offsets.back() = 4 * tetrahedra;
  publish(dataset, cells);
}

std::uint64_t mixed_bytes(std::int64_t n) {
  // As if every cube were six tetrahedra or pyramids with five ids each, and had a point in its middle.
  const auto cubes = static_cast<std::uint64_t>((n - 1) * (n - 1) * (n - 1));
  const auto points = static_cast<std::uint64_t>(n * n * n) + cubes;
  return points * (sizeof(Vec3f) + sizeof(float)) + 7 * cubes * (1 + 6 * sizeof(std::int64_t));
}

void fill_mixed(Dataset& dataset, std::int64_t n, double (*field)(Vec3d), const Task& task) {
  const auto cells = std::make_shared<Cells>();
  cells->points.resize(static_cast<std::size_t>(n * n * n));
  cells->values.resize(static_cast<std::size_t>(n * n * n));
  fill_lattice_points(*cells, n, field, task);

  const std::int64_t side = n - 1;
  for (std::int64_t k = 0; k < side; ++k) {
    task.check();
    for (std::int64_t j = 0; j < side; ++j)
      for (std::int64_t i = 0; i < side; ++i) {
        const auto c = corners(i, j, k, n);
        const std::int64_t quarter = 4 * i / side;
        if (quarter == 0) {
          cells->add(CellType::hexahedron, {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]});
        } else if (quarter == 1) {
          // VTK's wedge: the normal of its first triangle points out of it.
          cells->add(CellType::wedge, {c[0], c[3], c[1], c[4], c[7], c[5]});
          cells->add(CellType::wedge, {c[0], c[2], c[3], c[4], c[6], c[7]});
        } else if (quarter == 2) {
          const auto middle = static_cast<std::int64_t>(cells->points.size());
          const double half = 1.0 / static_cast<double>(side);
          const Vec3d p{coordinate(i, n) + half, coordinate(j, n) + half, coordinate(k, n) + half};
          cells->points.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
          cells->values.push_back(static_cast<float>(field(p)));
          cells->add(CellType::pyramid, {c[0], c[2], c[6], c[4], middle});  // -x; bases are counter-clockwise seen from the apex
          cells->add(CellType::pyramid, {c[0], c[4], c[5], c[1], middle});  // -y
          cells->add(CellType::pyramid, {c[2], c[3], c[7], c[6], middle});  // +y
          cells->add(CellType::pyramid, {c[0], c[1], c[3], c[2], middle});  // -z
          cells->add(CellType::pyramid, {c[4], c[6], c[7], c[5], middle});  // +z
          if (4 * (i + 1) / side == 2) {
            cells->add(CellType::pyramid, {c[1], c[5], c[7], c[3], middle});  // +x
          } else {  // the next cube is tetrahedra, which cut this face from its lowest to its highest corner
            cells->add(CellType::tetrahedron, {c[1], c[7], c[3], middle});
            cells->add(CellType::tetrahedron, {c[1], c[5], c[7], middle});
          }
        } else {
          for (const auto& path : kKuhn) cells->add(CellType::tetrahedron, {c[path[0]], c[path[1]], c[path[2]], c[path[3]]});
        }
      }
  }
  publish(dataset, cells);
}

}  // namespace isostrata
