#include "rendering/order/visibility_order.h"

#include <gtest/gtest.h>

#include <random>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/order/cell_order.h"
#include "support/box_mesh.h"
#include "support/oracle.h"
#include "support/order_errors.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

Camera camera_at(Vec3d eye) {
  Camera camera;
  camera.eye = eye;
  camera.at = {0.01, 0.02, 0.03};
  camera.up = {0.1, 1, 0.2};
  return camera;
}

struct Violations {
  std::int64_t pairs = 0;        // of tetrahedra that a ray meets one after the other
  std::int64_t wrong = 0;        // drawn in the wrong order
  std::int64_t overlapping = 0;  // whose segments overlap on the ray: inverted tetrahedra
};

/// Shoots rays from the eye at random points of the mesh and looks whether what they meet is drawn back to front.
Violations count_violations(const IntervalMesh& mesh, const std::vector<std::uint32_t>& order, Vec3d eye, int rays,
                            unsigned seed) {
  std::vector<std::int64_t> rank(mesh.tetrahedra.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<std::int64_t>(i);
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::size_t> any(0, mesh.positions.size() - 1);
  std::uniform_real_distribution<double> jitter(-0.05, 0.05);
  const double epsilon = 1e-7 * bounds_of(mesh).diagonal();
  Violations violations;
  for (int r = 0; r < rays; ++r) {
    const Vec3d target = mesh.positions[any(random)] + Vec3d{jitter(random), jitter(random), jitter(random)};
    const Vec3d direction = normalized(target - eye);
    std::vector<OracleSegment> met;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
      OracleSegment segment{};
      if (rank[t] >= 0 && oracle_segment(mesh, nullptr, t, {eye, direction}, segment) && segment.leave - segment.enter > epsilon)
        met.push_back(segment);
    }
    for (std::size_t a = 0; a < met.size(); ++a)
      for (std::size_t b = 0; b < met.size(); ++b) {
        if (a == b || met[a].enter > met[b].enter) continue;
        if (met[a].leave > met[b].enter + epsilon) {
          ++violations.overlapping;
          continue;
        }
        ++violations.pairs;  // a is in front of b
        violations.wrong += rank[met[a].tetrahedron] < rank[met[b].tetrahedron];
      }
  }
  return violations;
}

/// Six boxes along x, seven along y, five along z, of uneven sizes; some axes fall.
RectilinearGrid uneven_grid(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> step(0.1, 1.0);
  RectilinearGrid grid;
  grid.dims = {7, 8, 6};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double sign = (seed >> axis & 1) ? -1 : 1;
    double x = -2 * sign;
    for (std::int64_t i = 0; i < grid.dims[axis]; ++i, x += sign * step(random)) grid.axes[axis].push_back(x);
  }
  return grid;
}

TEST(VisibilityOrder, IndexDistanceIsExactFromOutsideInsideAndOnTheWalls) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const RectilinearGrid shape = uneven_grid(seed);
    const Grid grid{shape, {}, {}};
    IntervalMesh mesh =
        box_mesh(shape, [](auto i, auto j, auto k) { return (i + j + k) % 3 == 0 ? -1 : static_cast<int>((i * j + k) % 2); });
    const std::vector<std::uint8_t> drawn(mesh.summaries.size(), 1), mixed(mesh.summaries.size(), 0);
    const Vec3d wall{shape.axes[0][3], shape.axes[1][2], 0.1};
    const Box3d box = bounds_of(mesh);
    for (const Vec3d eye :
         {Vec3d{9, 7, 5}, Vec3d{-6, 0.3, 0.1}, Vec3d{0.2, 0.1, -8}, box.center(), wall, box.lower, Vec3d{0.05, 20, 0.07}}) {
      const VisibilityOrder order = visibility_order(&grid, mesh, {drawn, mixed}, camera_at(eye));
      EXPECT_TRUE(order.exact) << order.method << ", seed " << seed;
      EXPECT_EQ(order.tetrahedra.size(), mesh.tetrahedra.size());
      const Violations violations = count_violations(mesh, order.tetrahedra, eye, 60, seed);
      EXPECT_GT(violations.pairs, 100);
      EXPECT_EQ(violations.wrong, 0) << "of " << violations.pairs << ", seed " << seed << ", eye " << eye.x << "," << eye.y << ","
                                     << eye.z;
    }
  }
}

TEST(VisibilityOrder, IndexDistanceIsExactForParallelRaysFromAnywhere) {
  std::mt19937 random(12);
  std::normal_distribution<double> number;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const RectilinearGrid shape = uneven_grid(seed);
    const Grid grid{shape, {}, {}};
    DrawInput input = input_of(box_mesh(shape, [](auto i, auto j, auto k) { return static_cast<int>((i + 2 * j + k) % 3); }));
    input.camera.at = input.bounds.center();
    input.camera.eye = input.camera.at + Vec3d{number(random), number(random), seed == 1 ? 0.0 : number(random)};  // often inside
    input.camera.fov_deg = 120;
    input.camera.orthographic = true;
    const std::vector<std::uint8_t> drawn(3, 1), mixed(3, 0);
    const VisibilityOrder order = visibility_order(&grid, *input.mesh, {drawn, mixed}, input.camera);
    EXPECT_TRUE(order.exact) << order.method << ", seed " << seed;
    const OrderErrors errors = order_errors(input, order.tetrahedra);
    EXPECT_GT(errors.fragments, 1000);
    EXPECT_EQ(errors.wrong, 0) << "of " << errors.fragments << ", seed " << seed;
  }
}

TEST(VisibilityOrder, IndexDistanceIsExactForExtractedIntervals) {
  const auto dataset = make_analytic("marschner-lobb:12", {}, Task{});
  const std::vector<Interval> intervals{{0.1, 0.35}, {0.35, 0.5}, {0.6, 0.9}};
  const IntervalMesh mesh = extract_intervals(dataset->grid, dataset->arrays[0], intervals, {}, Task{});
  const std::vector<std::uint8_t> drawn{1, 1, 1}, mixed{0, 0, 0};
  for (const Vec3d eye : {Vec3d{3, 2, 4}, Vec3d{-5, 0.01, 0.02}, Vec3d{0.1, -0.2, 0.15}}) {
    const VisibilityOrder order = visibility_order(&dataset->grid, mesh, {drawn, mixed}, camera_at(eye));
    const Violations violations = count_violations(mesh, order.tetrahedra, eye, 150, 11);
    EXPECT_GT(violations.pairs, 1000);
    // Inverted tetrahedra overlap their neighbours and can make a cell's order undefined; nothing else may be wrong.
    EXPECT_LE(violations.wrong, order.exact ? 0 : violations.pairs / 1000) << order.method;
  }
}

TEST(VisibilityOrder, IntervalsOfOneColourNeedNoOrderAmongThemselvesButKeepItAgainstOthers) {
  const auto dataset = make_analytic("torus:12", {}, Task{});
  const std::vector<Interval> intervals{{0.1, 0.35}, {0.35, 0.6}};
  const IntervalMesh mesh = extract_intervals(dataset->grid, dataset->arrays[0], intervals, {}, Task{});
  const std::vector<std::uint8_t> drawn{1, 1}, one_color{1, 1};
  const Vec3d eye{3, 2, 4};
  const VisibilityOrder order = visibility_order(&dataset->grid, mesh, {drawn, one_color}, camera_at(eye));
  std::vector<std::int64_t> rank(mesh.tetrahedra.size());
  for (std::size_t i = 0; i < order.tetrahedra.size(); ++i) rank[order.tetrahedra[i]] = static_cast<std::int64_t>(i);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-0.8, 0.8);
  std::int64_t pairs = 0, wrong = 0;
  for (int r = 0; r < 200; ++r) {
    const Vec3d direction = normalized(Vec3d{number(random), number(random), number(random)} - eye);
    std::vector<OracleSegment> met;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
      OracleSegment segment{};
      if (oracle_segment(mesh, nullptr, t, {eye, direction}, segment)) met.push_back(segment);
    }
    for (const OracleSegment& a : met)
      for (const OracleSegment& b : met) {
        if (mesh.tetrahedron_interval[a.tetrahedron] == mesh.tetrahedron_interval[b.tetrahedron] || a.leave > b.enter + 1e-7)
          continue;
        ++pairs;
        wrong += rank[a.tetrahedron] < rank[b.tetrahedron];
      }
  }
  EXPECT_GT(pairs, 500);
  EXPECT_LE(wrong, order.exact ? 0 : pairs / 1000) << order.method;
}

TEST(VisibilityOrder, LeavesOutWhatIsNotDrawn) {
  const RectilinearGrid shape = even_grid(4, 4, 4, {-1, -1, -1}, {1, 1, 1});
  const Grid grid{shape, {}, {}};
  const IntervalMesh mesh = box_mesh(shape, [](auto i, auto, auto) { return static_cast<int>(i % 2); });
  const std::vector<std::uint8_t> drawn{0, 1}, mixed{0, 0};
  for (const VisibilityOrder& order :
       {visibility_order(&grid, mesh, {drawn, mixed}, camera_at({3, 3, 3})),
        centroid_order(mesh, {drawn, mixed}, camera_at({3, 3, 3})), mesh_order(mesh, {drawn, mixed})}) {
    EXPECT_EQ(order.tetrahedra.size(), static_cast<std::size_t>(mesh.summaries[1].tetrahedra)) << order.method;
    for (const std::uint32_t t : order.tetrahedra) EXPECT_EQ(mesh.tetrahedron_interval[t], 1);
  }
}

TEST(VisibilityOrder, CentroidsComeFarFirst) {
  const RectilinearGrid shape = even_grid(6, 6, 6, {-1, -1, -1}, {1, 1, 1});
  const IntervalMesh mesh = box_mesh(shape, [](auto, auto, auto) { return 0; });
  const Vec3d eye{0.3, 0.2, 0.1};
  const std::vector<std::uint8_t> one{1};
  const VisibilityOrder order = visibility_order(nullptr, mesh, {one, one}, camera_at(eye));
  EXPECT_FALSE(order.exact);
  EXPECT_EQ(order.method, "centroid (approximate)");
  const auto distance = [&](std::uint32_t t) {
    Vec3d sum;
    for (const std::uint32_t p : mesh.tetrahedra[t]) sum = sum + mesh.positions[p] * 0.25;
    return length(sum - eye);
  };
  for (std::size_t i = 1; i < order.tetrahedra.size(); ++i)
    EXPECT_LE(distance(order.tetrahedra[i]), distance(order.tetrahedra[i - 1]) + 1e-6);
}

TEST(CellOrder, OrdersTheSixTetrahedraOfACubeFromEverywhere) {
  IntervalMesh mesh;
  add_box(mesh, {-1, -1, -1}, {1, 1, 1}, 0, 0);
  const std::vector<std::uint8_t> mixed{0};
  CellOrder cell_order(mixed);
  std::mt19937 random(3);
  std::normal_distribution<double> number(0, 2);
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3d eye{number(random), number(random), number(random)};
    std::vector<std::uint32_t> ids{0, 1, 2, 3, 4, 5};
    std::shuffle(ids.begin(), ids.end(), random);
    EXPECT_EQ(cell_order.sort(mesh, eye, ids), 0) << "trial " << trial << ", seed 3";
    EXPECT_EQ(count_violations(mesh, ids, eye, 20, static_cast<unsigned>(trial)).wrong, 0) << "trial " << trial << ", seed 3";
  }
}

TEST(CellOrder, SaysWhereInteriorsMeet) {
  IntervalMesh mesh;
  const auto a = add_point(mesh, {0, 0, 0}), b = add_point(mesh, {1, 0, 0}), c = add_point(mesh, {0, 1, 0}),
             d = add_point(mesh, {0, 0, 1});
  const auto e = add_point(mesh, {0.1, 0.1, 0.1}), f = add_point(mesh, {1.1, 0.1, 0.1}), g = add_point(mesh, {0.1, 1.1, 0.1}),
             h = add_point(mesh, {0.1, 0.1, 1.1});
  add_tetrahedron(mesh, {a, b, c, d}, 0);
  add_tetrahedron(mesh, {e, f, g, h}, 0);
  const std::vector<std::uint8_t> mixed{0};
  std::vector<std::uint32_t> ids{0, 1};
  EXPECT_EQ(CellOrder(mixed).sort(mesh, {5, 5, 5}, ids), 1);
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{0, 1}));  // the nearer one is drawn last
}

}  // namespace
}  // namespace isostrata
