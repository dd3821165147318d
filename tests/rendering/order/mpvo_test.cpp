#include "rendering/order/mpvo.h"

#include <gtest/gtest.h>

#include <random>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/order/visibility_order.h"
#include "support/order_errors.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

struct Scene {
  std::shared_ptr<const Dataset> dataset;
  DrawInput input;
  VisibilityOrder order() const {
    const std::vector<std::uint8_t> drawn(input.styles.size(), 1), mixed(input.styles.size(), 0);
    return visibility_order(input.grid, *input.mesh, {drawn, mixed}, input.camera, input.width, input.height);
  }
  /// As if each interval had many colours: every pair of tetrahedra on a ray counts.
  OrderErrors errors(const VisibilityOrder& order) const {
    DrawInput mapped = input;
    for (IntervalStyle& style : mapped.styles) style.color_map = "gray";
    return order_errors(mapped, order.tetrahedra);
  }
};

Scene scene_of(const char* data) {
  Scene scene{make_analytic(data, {}, Task{}), {}};
  const PointArray& array = scene.dataset->arrays[0];
  const double low = array.lower, span = array.upper - low;
  const std::vector<Interval> intervals{{low + 0.1 * span, low + 0.4 * span}, {low + 0.4 * span, low + 0.7 * span}};
  scene.input = input_of(extract_intervals(scene.dataset->grid, array, intervals, {}, Task{}));
  scene.input.grid = &scene.dataset->grid;
  scene.input.bounds = scene.dataset->bounds;
  return scene;
}

Camera random_camera(const Box3d& bounds, int trial, std::mt19937& random) {
  std::normal_distribution<double> number;
  Camera camera;
  camera.at = bounds.center();
  const Vec3d direction = normalized(Vec3d{number(random), number(random), number(random)});
  const bool inside = trial % 4 == 3;
  camera.eye = camera.at + direction * (bounds.diagonal() * (inside ? 0.2 : 1.5));
  camera.up = {0.1, 1, 0.2};
  camera.fov_deg = inside ? 80 : 40;
  camera.orthographic = trial % 4 == 2;
  return camera;
}

TEST(Mpvo, IsExactOnConvexMeshesOfPlaneFaces) {
  std::mt19937 random(41);
  for (const char* data : {"tets:8", "mixed:7"}) {
    Scene scene = scene_of(data);
    for (int trial = 0; trial < 8; ++trial) {
      scene.input.camera = random_camera(scene.input.bounds, trial, random);
      const VisibilityOrder order = scene.order();
      EXPECT_TRUE(order.exact) << order.method << ", " << data << ", trial " << trial << ", seed 41";
      EXPECT_EQ(order.tetrahedra.size(), scene.input.mesh->tetrahedra.size());
      const OrderErrors errors = scene.errors(order);
      EXPECT_GT(errors.fragments, 1000) << data << ", trial " << trial << ", seed 41";
      EXPECT_EQ(errors.wrong, 0) << "of " << errors.fragments << ", " << data << ", trial " << trial << ", seed 41";
    }
  }
}

TEST(Mpvo, StaysBelowATenthOfAPercentOnCurvedGridsWithAHole) {
  std::mt19937 random(42);
  Scene scene = scene_of("cylinder:24x16x8");
  for (int trial = 0; trial < 8; ++trial) {
    scene.input.camera = random_camera(scene.input.bounds, trial, random);
    const VisibilityOrder order = scene.order();
    EXPECT_EQ(order.tetrahedra.size(), scene.input.mesh->tetrahedra.size());
    const OrderErrors errors = scene.errors(order);
    EXPECT_GT(errors.fragments, 1000) << "trial " << trial << ", seed 42";
    EXPECT_LT(errors.share(), 1e-3) << errors.wrong << " of " << errors.fragments << ", " << order.method << ", trial " << trial
                                    << ", seed 42";
  }
}

TEST(FaceGraph, JoinsTheSeamOfAnOGrid) {
  const auto dataset = make_analytic("cylinder:12x8x5", {}, Task{});
  const auto graph = face_graph(dataset->grid);
  ASSERT_TRUE(graph);
  EXPECT_EQ(graph->joined.size(), 7u * 4);
  EXPECT_EQ(graph->exterior.size(), 2 * 11u * 4 + 2 * 11u * 7);  // inner and outer wall, two ends
  EXPECT_FALSE(graph->convex);
  EXPECT_EQ(graph, face_graph(dataset->grid));  // kept
}

TEST(FaceGraph, KnowsWhatIsConvex) {
  for (const char* data : {"tets:5", "mixed:6"}) {
    const auto dataset = make_analytic(data, {}, Task{});
    const auto graph = build_face_graph(dataset->grid);
    EXPECT_TRUE(graph->convex) << data;
    EXPECT_TRUE(graph->plane_faces) << data;
    EXPECT_TRUE(graph->joined.empty()) << data;
  }
}

}  // namespace
}  // namespace isostrata
