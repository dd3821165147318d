#include "data/grids/split_polyhedron.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <random>

#include "support/edge_points_of.h"
#include "support/refined_cubes.h"
#include "support/truncated_cubes.h"
#include "support/voronoi_cells.h"

namespace isostrata {
namespace {

using Cycle = std::vector<std::int64_t>;

std::function<Vec3d(std::int64_t)> positions(const std::vector<Vec3d>& points) {
  return [&points](std::int64_t id) { return points[static_cast<std::size_t>(id)]; };
}

using test::faces_of;

Vec3d piece_point(const PolyhedronSplit& split, const std::vector<Vec3d>& points, std::int64_t id) {
  return id == kAddedPoint ? split.added : points[static_cast<std::size_t>(id)];
}

/// Exact for flat faces.
double volume(const PolyhedronSplit& split, const std::vector<Vec3d>& points) {
  double six = 0;
  std::size_t at = 0;
  for (const CellType type : split.types) {
    const auto p = [&](int v) { return piece_point(split, points, split.connectivity[at + static_cast<std::size_t>(v)]); };
    for (const CellFace& face : topology(type).faces)
      for (int first = 0; first < face.size; ++first)  // the mean of all fans: cells agree on faces that are not plane
        for (int i = 1; i + 1 < face.size; ++i) {
          const auto corner = [&](int k) { return p(face.vertex[static_cast<std::size_t>((first + k) % face.size)]); };
          six += orient3d(p(0), corner(0), corner(i), corner(i + 1)) / face.size;
        }
    at += static_cast<std::size_t>(topology(type).vertex_count);
  }
  return six / 6;
}

/// The pieces' faces as sorted ids, the added point as `added`, each with how often it occurs.
std::map<Cycle, int> piece_faces(const PolyhedronSplit& split, std::int64_t added) {
  std::map<Cycle, int> uses;
  std::size_t at = 0;
  for (const CellType type : split.types) {
    for (const CellFace& face : topology(type).faces) {
      Cycle ids;
      for (int i = 0; i < face.size; ++i) {
        const std::int64_t id = split.connectivity[at + static_cast<std::size_t>(face.vertex[static_cast<std::size_t>(i)])];
        ids.push_back(id == kAddedPoint ? added : id);
      }
      std::sort(ids.begin(), ids.end());
      ++uses[ids];
    }
    at += static_cast<std::size_t>(topology(type).vertex_count);
  }
  return uses;
}

/// Another way to write the same face.
Cycle rewritten(Cycle cycle, std::mt19937_64& random) {
  std::rotate(cycle.begin(), cycle.begin() + static_cast<std::ptrdiff_t>(random() % cycle.size()), cycle.end());
  if (random() % 2) std::reverse(cycle.begin(), cycle.end());
  return cycle;
}

TEST(SplitPolyhedron, KeepsTheFourCellsWhateverWayTheyAreWritten) {
  std::mt19937_64 random(11);
  const std::map<CellType, std::vector<Vec3d>> shapes{
      {CellType::tetrahedron, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
      {CellType::pyramid, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}}},
      {CellType::wedge, {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}}},
      {CellType::hexahedron, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}}};
  const std::map<CellType, double> volumes{
      {CellType::tetrahedron, 1.0 / 6}, {CellType::pyramid, 1.0 / 3}, {CellType::wedge, 0.5}, {CellType::hexahedron, 1}};
  for (const auto& [type, shape] : shapes)
    for (int trial = 0; trial < 50; ++trial) {
      Cycle numbers(shape.size());
      std::iota(numbers.begin(), numbers.end(), 0);
      std::shuffle(numbers.begin(), numbers.end(), random);
      std::vector<Vec3d> points(shape.size());
      for (std::size_t v = 0; v < shape.size(); ++v) points[static_cast<std::size_t>(numbers[v])] = shape[v];
      std::vector<Cycle> cycles;
      std::map<Cycle, int> expected;
      for (const CellFace& face : topology(type).faces) {
        Cycle cycle;
        for (int i = 0; i < face.size; ++i)
          cycle.push_back(numbers[static_cast<std::size_t>(face.vertex[static_cast<std::size_t>(i)])]);
        cycles.push_back(rewritten(cycle, random));
        std::sort(cycle.begin(), cycle.end());
        expected[cycle] = 1;
      }
      std::shuffle(cycles.begin(), cycles.end(), random);
      PolyhedronSplit split;
      split_polyhedron(faces_of(cycles), positions(points), {}, split);
      SCOPED_TRACE(std::string(topology(type).name) + ", seed 11, trial " + std::to_string(trial));
      ASSERT_EQ(split.kind, SplitKind::whole);
      ASSERT_EQ(split.types, std::vector{type});
      ASSERT_EQ(piece_faces(split, -1), expected);
      ASSERT_NEAR(volume(split, points), volumes.at(type), 1e-14) << "right-handed";
    }
}

/// Truncated cubes, Voronoi cells, or cubes of which some are refined: with points in the middle of edges, or near it.
test::PolyhedralMesh mesh_of(std::uint64_t seed) {
  const std::array<std::int64_t, 3> cubes{4, 3, 3};
  if (seed % 4 == 0) return test::truncated_cubes(cubes, seed);
  return seed % 4 == 1 ? test::voronoi_cells(cubes, seed) : test::refined_cubes(cubes, seed, seed % 4 == 2 ? 0 : 0.06);
}

TEST(SplitPolyhedron, ConformsAndFillsSpaceWithPolyhedraOfAllSorts) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const test::PolyhedralMesh mesh = mesh_of(seed);
    const auto linear = [](const Vec3d& p) { return 1 + 2 * p.x - 3 * p.y + 0.5 * p.z; };
    std::map<Cycle, int> uses;
    double total = 0;
    std::int64_t added = static_cast<std::int64_t>(mesh.points.size());
    const EdgePoints edge_points = test::edge_points_of(mesh);
    PolyhedronSplit split;
    for (const std::vector<Cycle>& cell : mesh.cells) {
      split_polyhedron(faces_of(cell), positions(mesh.points), edge_points, split);
      ASSERT_NE(split.kind, SplitKind::open);
      ASSERT_NE(split.kind, SplitKind::overlapping);
      total += volume(split, mesh.points);
      for (const auto& [face, n] : piece_faces(split, added)) uses[face] += n;
      if (split.kind == SplitKind::star) {
        double value = 0, sum = 0;
        for (std::size_t i = 0; i < split.points.size(); ++i) {
          value += split.weights[i] * linear(mesh.points[static_cast<std::size_t>(split.points[i])]);
          sum += split.weights[i];
        }
        ASSERT_NEAR(sum, 1, 1e-12);
        ASSERT_NEAR(value, linear(split.added), 1e-12);
      }
      ++added;
    }
    EXPECT_NEAR(total, mesh.volume, 1e-12 * mesh.volume);
    std::int64_t outer = 0;
    for (const auto& [face, n] : uses) {
      ASSERT_LE(n, 2);
      outer += n == 1;
      if (n != 1) continue;
      bool on_the_box = false;
      for (int side = 0; side < 6; ++side)
        on_the_box =
            on_the_box || std::all_of(face.begin(), face.end(), [&, side, dims = std::array{4.0, 3.0, 3.0}](std::int64_t id) {
              if (id >= static_cast<std::int64_t>(mesh.points.size())) return false;
              return mesh.points[static_cast<std::size_t>(id)][side / 2] ==
                     (side % 2 ? dims[static_cast<std::size_t>(side / 2)] : 0.0);
            });
      ASSERT_TRUE(on_the_box) << "a face that only one piece has lies on the boundary";
    }
    EXPECT_GT(outer, 0);
  }
}

TEST(SplitPolyhedron, CutsAMeshAlikeWherePointsMove) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    test::PolyhedralMesh mesh = seed % 2 ? test::voronoi_cells({4, 3, 3}, seed) : test::refined_cubes({4, 3, 3}, seed);
    const auto pieces = [&] {
      const EdgePoints edge_points = test::edge_points_of(mesh);
      std::vector<std::int64_t> all;
      PolyhedronSplit split;
      for (const std::vector<Cycle>& cell : mesh.cells) {
        split_polyhedron(faces_of(cell), positions(mesh.points), edge_points, split);
        all.insert(all.end(), split.connectivity.begin(), split.connectivity.end());
      }
      return all;
    };
    const std::vector<std::int64_t> before = pieces();
    for (Vec3d& p : mesh.points) p = {p.x + 0.3 * p.y, 1.2 * p.y - 0.1 * p.z, 0.9 * p.z + 0.2 * p.x};
    EXPECT_EQ(pieces(), before) << "seed " << seed;
  }
}

/// Unit cubes of a lattice as one polyhedron: the faces that only one of them has.
std::vector<Cycle> union_of_cubes(const std::vector<std::array<int, 3>>& cubes, int n) {
  std::map<Cycle, Cycle> faces;
  for (const auto& [i, j, k] : cubes) {
    Cycle ids;
    for (const auto& c : kHexahedronCorners) ids.push_back(i + c[0] + n * (j + c[1] + n * (k + c[2])));
    for (const CellFace& face : topology(CellType::hexahedron).faces) {
      Cycle cycle;
      for (const int v : face.vertex) cycle.push_back(ids[static_cast<std::size_t>(v)]);
      Cycle key = cycle;
      std::sort(key.begin(), key.end());
      if (!faces.try_emplace(key, cycle).second) faces.erase(key);
    }
  }
  std::vector<Cycle> out;
  for (auto& [key, cycle] : faces) out.push_back(cycle);
  return out;
}

std::vector<Vec3d> lattice(int n) {
  std::vector<Vec3d> points;
  for (int p = 0; p < n * n * n; ++p) points.push_back({double(p % n), double(p / n % n), double(p / n / n)});
  return points;
}

TEST(SplitPolyhedron, FindsAPointThatSeesAllOfAnLShape) {
  // A long L, whose mean of points lies outside the corner that sees both arms.
  const auto points = lattice(5);
  const auto cycles = union_of_cubes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}}, 5);
  PolyhedronSplit split;
  split_polyhedron(faces_of(cycles), positions(points), {}, split);
  ASSERT_EQ(split.kind, SplitKind::star);
  EXPECT_NEAR(volume(split, points), 7, 1e-12);
  EXPECT_LT(split.added.x, 1);
  EXPECT_LT(split.added.y, 1);
  const double sum = std::accumulate(split.weights.begin(), split.weights.end(), 0.0);
  EXPECT_NEAR(sum, 1, 1e-12);
  Vec3d at;
  for (std::size_t i = 0; i < split.points.size(); ++i)
    at = at + points[static_cast<std::size_t>(split.points[i])] * split.weights[i];
  EXPECT_NEAR(length(at - split.added), 0, 1e-12) << "a linear field stays linear";
}

TEST(SplitPolyhedron, LeavesNoPieceFlatWhereTheMeanLiesInTheEdgeOfAnL) {
  // A prism of six sides; the mean of its points is the middle of the edge that points inwards.
  const std::vector<std::array<double, 2>> outline{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  std::vector<Vec3d> points;
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] : outline) points.push_back({x, y, z});
  std::vector<Cycle> cycles{{5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}};
  for (std::int64_t i = 0; i < 6; ++i) cycles.push_back({i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i});
  PolyhedronSplit split;
  split_polyhedron(faces_of(cycles), positions(points), {}, split);
  ASSERT_EQ(split.kind, SplitKind::star);
  std::size_t at = 0;
  double sum = 0;
  for (const CellType type : split.types) {
    PolyhedronSplit piece = split;
    piece.types = {type};
    const auto count = static_cast<std::size_t>(topology(type).vertex_count);
    piece.connectivity.assign(split.connectivity.begin() + static_cast<std::ptrdiff_t>(at),
                              split.connectivity.begin() + static_cast<std::ptrdiff_t>(at + count));
    at += count;
    EXPECT_GT(volume(piece, points), 0.01);
    sum += volume(piece, points);
  }
  EXPECT_NEAR(sum, 3, 1e-12);
}

TEST(SplitPolyhedron, SaysWhereNoPointSeesAllFaces) {
  const auto points = lattice(4);
  PolyhedronSplit split;
  split_polyhedron(faces_of(union_of_cubes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}, {0, 2, 0}, {2, 2, 0}}, 4)),
                   positions(points), {}, split);
  EXPECT_EQ(split.kind, SplitKind::overlapping);
  EXPECT_FALSE(split.types.empty());
}

TEST(SplitPolyhedron, RefusesWhatIsNotClosed) {
  const auto points = lattice(2);
  auto cycles = union_of_cubes({{0, 0, 0}}, 2);
  PolyhedronSplit split;
  cycles.pop_back();
  split_polyhedron(faces_of(cycles), positions(points), {}, split);
  EXPECT_EQ(split.kind, SplitKind::open);
  EXPECT_TRUE(split.types.empty());
  cycles.push_back(cycles.front());  // one face twice, another missing
  split_polyhedron(faces_of(cycles), positions(points), {}, split);
  EXPECT_EQ(split.kind, SplitKind::open);
  split_polyhedron({}, positions(points), {}, split);
  EXPECT_EQ(split.kind, SplitKind::open);
  split_polyhedron(faces_of({{0}, {1, 1, 1}, {2, 3}}), positions(points), {}, split);
  EXPECT_EQ(split.kind, SplitKind::open);
}

std::vector<std::array<std::int64_t, 3>> cut(const Cycle& cycle, const std::vector<Vec3d>& points) {
  Cycle flat;
  cut_polygon(cycle, positions(points), {}, flat);
  std::vector<std::array<std::int64_t, 3>> triangles;
  for (std::size_t t = 0; t < flat.size(); t += 3) {
    std::array<std::int64_t, 3> triangle{flat[t], flat[t + 1], flat[t + 2]};
    std::sort(triangle.begin(), triangle.end());
    triangles.push_back(triangle);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(CutPolygon, CoversStarsAndCombsAlikeFromBothSides) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> radius(0.2, 1);
  for (int trial = 0; trial < 300; ++trial) {
    SCOPED_TRACE("seed 12, trial " + std::to_string(trial));
    const std::size_t n = 3 + random() % 10;
    Cycle ids(n);
    std::iota(ids.begin(), ids.end(), 0);
    std::shuffle(ids.begin(), ids.end(), random);
    std::vector<Vec3d> points(n);
    double area = 0;
    const bool comb = trial % 3 == 0 && n >= 5;  // a row of teeth: no fan covers it
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 2 * std::acos(-1.0) * static_cast<double>(i) / static_cast<double>(n), r = radius(random);
      points[static_cast<std::size_t>(ids[i])] = {r * std::cos(angle), r * std::sin(angle), 0.5};
      if (comb) {
        const double x = static_cast<double>(n - 2 - std::min(i, n - 2)) + (i % 2 ? 0 : 0.4);
        points[static_cast<std::size_t>(ids[i])] = i == n - 1   ? Vec3d{-1, -3, 0.5}
                                                   : i == n - 2 ? Vec3d{-1, 3, 0.5}
                                                                : Vec3d{x,
                                                                        i == 0  ? -3.0
                                                                        : i % 2 ? 2.0
                                                                                : 0.5,
                                                                        0.5};
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3d &a = points[static_cast<std::size_t>(ids[i])], &b = points[static_cast<std::size_t>(ids[(i + 1) % n])];
      area += (a.x * b.y - a.y * b.x) / 2;
    }
    const auto triangles = cut(ids, points);
    ASSERT_EQ(triangles.size(), n - 2);
    double covered = 0;
    for (const auto& t : triangles)
      covered += length(cross(points[static_cast<std::size_t>(t[1])] - points[static_cast<std::size_t>(t[0])],
                              points[static_cast<std::size_t>(t[2])] - points[static_cast<std::size_t>(t[0])])) /
                 2;
    ASSERT_NEAR(covered, std::abs(area), 1e-12 * (1 + covered)) << (comb ? "comb" : "star");
    for (int other = 0; other < 4; ++other) ASSERT_EQ(cut(rewritten(ids, random), points), triangles);
  }
}

}  // namespace
}  // namespace isostrata
