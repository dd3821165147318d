#include "data/derived/proxy_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "data/derived/value_curves.h"
#include "support/field_dataset.h"

namespace isostrata {
namespace {

using testing::field_dataset;
using testing::mesh_dataset;
using testing::OwnedMesh;

/// n^3 cubes over [-1, 1], their order as `order` says.
OwnedMesh cubes(int n, std::uint64_t seed = 0) {
  OwnedMesh mesh;
  const auto id = [&](int i, int j, int k) { return static_cast<std::int64_t>(i + (n + 1) * (j + (n + 1) * k)); };
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) mesh.points.push_back({2.0 * i / n - 1, 2.0 * j / n - 1, 2.0 * k / n - 1});
  std::vector<std::array<int, 3>> order;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) order.push_back({i, j, k});
  if (seed) std::shuffle(order.begin(), order.end(), std::mt19937_64(seed));
  for (const auto& [i, j, k] : order)
    mesh.add(CellType::hexahedron, {id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k), id(i, j, k + 1),
                                    id(i + 1, j, k + 1), id(i + 1, j + 1, k + 1), id(i, j + 1, k + 1)});
  return mesh;
}

double wavy(Vec3d p) { return std::sin(2 * p.x) + p.y * p.z; }

TEST(ProxyGrid, DoesNotDependOnTheOrderOfCellsNorOnThreads) {
  for (const int n : {5, 40, 100}) {
    const auto straight = mesh_dataset(cubes(n), wavy), shuffled = mesh_dataset(cubes(n, 42), wavy);
    const ProxyGrid a = make_proxy(*straight, straight->arrays[0], Task()),
                    b = make_proxy(*shuffled, shuffled->arrays[0], Task());
    set_thread_count(1);
    const ProxyGrid c = make_proxy(*shuffled, shuffled->arrays[0], Task());
    set_thread_count(0);
    EXPECT_EQ(a.values, b.values) << n;
    EXPECT_EQ(b.values, c.values) << n;
    EXPECT_EQ(a.fill, 1);
  }
}

/// Six tetrahedra in each of n^3 cubes over [-1, 1]; but those with the point `without`.
OwnedMesh tetrahedra(int n, std::int64_t without = -1) {
  OwnedMesh mesh;
  const OwnedMesh hexahedra = cubes(n);
  mesh.points = hexahedra.points;
  constexpr std::array<std::array<std::size_t, 4>, 6> kSix{{{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}}};
  for (std::size_t c = 0; c < hexahedra.connectivity.size(); c += 8)
    for (const auto& of : kSix) {
      std::vector<std::int64_t> ids;
      for (const std::size_t v : of) ids.push_back(hexahedra.connectivity[c + v]);
      if (std::find(ids.begin(), ids.end(), without) == ids.end()) mesh.add(CellType::tetrahedron, ids);
    }
  return mesh;
}

TEST(ProxyGrid, LeavesOutCellsWithAValueThatIsNotFiniteHoweverManyCellsAPointHas) {
  constexpr int n = 12;
  constexpr std::int64_t at = 5 + 13 * (6 + 13 * 4);
  const OwnedMesh all = tetrahedra(n);
  const Vec3d there = all.points[at];
  const auto infinite = mesh_dataset(all, [&](Vec3d p) { return length(p - there) < 1e-9 ? std::numeric_limits<double>::infinity() : wavy(p); });
  const auto hole = mesh_dataset(tetrahedra(n, at), wavy);
  OwnedMesh few_cells = tetrahedra(n, at);
  for (int i = 0; i < 5000; ++i) few_cells.points.push_back({0, 0, 0});  // that no cell has
  const auto spare = mesh_dataset(few_cells, wavy);
  const ProxyGrid a = make_proxy(*infinite, infinite->arrays[0], Task()), b = make_proxy(*hole, hole->arrays[0], Task()),
                  c = make_proxy(*spare, spare->arrays[0], Task());
  EXPECT_LT(b.fill, 1);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t s = 0; s < a.size(); ++s) {
    ASSERT_TRUE(a.values[s] == b.values[s] || (std::isnan(a.values[s]) && std::isnan(b.values[s]))) << s;
    ASSERT_TRUE(a.values[s] == c.values[s] || (std::isnan(a.values[s]) && std::isnan(c.values[s]))) << s;
  }
}

TEST(ProxyGrid, EverySampleOfASolidMeshHasTheFieldsValueThere) {
  for (const int n : {3, 30, 100}) {
    const auto mesh = mesh_dataset(cubes(n), [](Vec3d p) { return 3 + p.x - 2 * p.y + p.z; });
    const ProxyGrid proxy = make_proxy(*mesh, mesh->arrays[0], Task());
    EXPECT_EQ(proxy.dims, (std::array<int, 3>{80, 80, 80}));
    for (std::size_t s = 0; s < proxy.size(); s += 101) {
      const Vec3d p = proxy.world(proxy.place(s));
      ASSERT_NEAR(proxy.value_at(proxy.values[s]), 3 + p.x - 2 * p.y + p.z, 0.05) << n;
    }
  }
}

TEST(ProxyGrid, OfAUniformGridHasItsPointsAndTheirSlopes) {
  const auto dataset = field_dataset({200, 100, 50}, [](Vec3d p) { return 5 * p.x; });
  const ProxyGrid proxy = make_proxy(*dataset, dataset->arrays[0], Task());
  EXPECT_LE(proxy.dims[0], kMostProxySamples);
  EXPECT_GE(proxy.dims[2], kFewestProxySamples);
  for (std::size_t s = 0; s < proxy.size(); s += 37) {
    EXPECT_NEAR(proxy.value_at(proxy.values[s]), 5 * proxy.world(proxy.place(s)).x, 1e-5);
    EXPECT_NEAR(proxy.slopes[s], 1, 1e-4) << "from 0 to 1 along the longest side";
  }
}

TEST(ProxyGrid, ShellsThinnerThanASampleAreThere) {
  OwnedMesh mesh;  // one layer of flat bricks, a thousandth thick
  const int n = 20;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) mesh.points.push_back({1.0 * i, 1.0 * j, std::sin(0.3 * i) + 0.001 * k});
  const auto id = [&](int i, int j, int k) { return static_cast<std::int64_t>(i + (n + 1) * (j + (n + 1) * k)); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      mesh.add(CellType::hexahedron, {id(i, j, 0), id(i + 1, j, 0), id(i + 1, j + 1, 0), id(i, j + 1, 0), id(i, j, 1),
                                      id(i + 1, j, 1), id(i + 1, j + 1, 1), id(i, j + 1, 1)});
  const auto shell = mesh_dataset(std::move(mesh), [](Vec3d p) { return p.x + p.y; });
  const ProxyGrid proxy = make_proxy(*shell, shell->arrays[0], Task());
  EXPECT_GE(proxy.count, 80 * 80);
  EXPECT_LT(proxy.thickness, 0.035);
}

TEST(ProxyGrid, AFewValuesThatAreFarAwayDoNotHideAllOthers) {
  const auto dataset =
      field_dataset<double>({40, 40, 40}, [](Vec3d p) { return p.x > 0.99 && p.y > 0.99 && p.z > 0.99 ? 1e9 : p.x; });
  const ProxyGrid proxy = make_proxy(*dataset, dataset->arrays[0], Task());
  EXPECT_LT(proxy.upper, 10);
  EXPECT_GT(ValueCurves(proxy).value_above(0.25), ValueCurves(proxy).value_above(0.75) + 0.2);
}

TEST(ProxyGrid, IsEmptyWhereThereIsNothingToLookAt) {
  const auto constant = field_dataset({8, 8, 8}, [](Vec3d) { return 3; });
  EXPECT_TRUE(make_proxy(*constant, constant->arrays[0], Task()).empty());
  const auto nothing = field_dataset({8, 8, 8}, [](Vec3d) { return NAN; });
  EXPECT_TRUE(make_proxy(*nothing, nothing->arrays[0], Task()).empty());
  auto endless = mesh_dataset(cubes(2), wavy);
  endless->bounds.include({INFINITY, 0, 0});
  EXPECT_FALSE(make_proxy(*endless, endless->arrays[0], Task()).empty()) << "the points themselves are finite";
}

TEST(ProxyGrid, LooksAtUniformGridsFromTheirEndsAndMirrored) {
  auto dataset = field_dataset({30, 20, 20}, [](Vec3d p) { return p.x + 2 * p.y; });
  UniformGrid& grid = std::get<UniformGrid>(dataset->grid.shape);
  grid.spacing.x *= -1;
  dataset->bounds = dataset->grid.bounds();
  const ProxyGrid proxy = make_proxy(*dataset, dataset->arrays[0], Task());
  for (std::size_t s = 0; s < proxy.size(); s += 11) {
    const Vec3d p = proxy.world(proxy.place(s));
    EXPECT_NEAR(proxy.value_at(proxy.values[s]), -(p.x + 1) - 1 + 2 * p.y, 1e-5);
  }
}

TEST(ValueCurves, CoherenceTellsNoiseFromBodies) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto noise = field_dataset({40, 40, 40}, [&](Vec3d) { return uniform(random); });
  const auto smooth = field_dataset({40, 40, 40}, [](Vec3d p) { return length(p); });
  const ValueCurves rough(make_proxy(*noise, noise->arrays[0], Task())), even(make_proxy(*smooth, smooth->arrays[0], Task()));
  EXPECT_NEAR(rough.coherence(0.7, true), 0.3, 0.05);
  EXPECT_GT(even.coherence(0.7, true), 0.9);
  EXPECT_NEAR(rough.value_above(0.25), 0.75, 0.02);
  EXPECT_NEAR(rough.share_above(0.9), 0.1, 0.02);
}

TEST(ValueCurves, StrengthIsTheMeanGradientOnTheIsosurface) {
  const auto dataset = field_dataset({60, 60, 60}, [](Vec3d p) { return std::tanh(6 * (p.x + 0.13 * p.y + 0.07 * p.z)); });
  const ValueCurves curves(make_proxy(*dataset, dataset->arrays[0], Task()));
  EXPECT_GT(curves.strength_at(0.5), 3 * curves.strength_at(0.05));
  EXPECT_EQ(peaks(curves.strength(), 0.3 * curves.strength_at(0.5)).size(), 1u);
}

}  // namespace
}  // namespace isostrata
