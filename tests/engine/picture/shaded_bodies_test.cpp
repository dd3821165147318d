// Gradients at all points are made where interiors are shaded by them, and nowhere else.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "data/dataset/analytic.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/without_mesh.h"
#include "extraction/bricks/brick_memory.h"
#include "support/steps_of.h"

namespace isostrata {
namespace {

Scene one_layer(double lower, double upper, double shading) {
  Scene scene;
  SceneInterval interval;
  interval.id = 1;
  interval.lower = lower;
  interval.upper = upper;
  scene.intervals.push_back(interval);
  scene.body_shading = shading;
  return scene;
}

/// The share of the mesh's points that have a unit vector.
double known(const ExtractedScene& extracted) {
  if (!extracted.body_normals || extracted.body_normals->size() != extracted.mesh->positions.size()) return 0;
  const auto unit = [](Vec3f n) { return std::abs(dot(n, n) - 1) < 1e-3f; };
  return static_cast<double>(std::count_if(extracted.body_normals->begin(), extracted.body_normals->end(), unit)) /
         static_cast<double>(extracted.body_normals->size());
}

TEST(ShadedBodies, HaveAGradientAtEveryPoint) {
  for (const char* name : {"torus:17", "tets:9", "mixed:8"}) {
    const std::shared_ptr<const Dataset> dataset = make_analytic(name, {}, Task{});
    const PointArray& array = dataset->arrays[0];
    Scene scene = one_layer(array.lower + 0.1 * (array.upper - array.lower), array.lower + 0.8 * (array.upper - array.lower), 0.7);
    scene.intervals[0].surface.lower = true;  // its normals are of its facets alone
    const auto extracted = extract_scene(dataset, scene, nullptr, Task{});
    EXPECT_GT(known(*extracted), 0.99) << name;
    const DrawInput input = draw_input(*extracted, scene, 16, 12);
    EXPECT_EQ(input.body_shading, 0.7) << name;
    EXPECT_EQ(input.body_normals, extracted->body_normals) << name;
    EXPECT_TRUE(input.normals) << name;
  }
}

TEST(ShadedBodies, CombinedRangesHaveThatOfTheArrayTheyAreRangesOf) {
  const std::shared_ptr<const Dataset> dataset = make_analytic("cylinder:16x12x8", {}, Task{});
  Scene scene = one_layer(0.95, 0.999, 1);
  scene.array = "Density";
  scene.terms.push_back({{RangeOperator::intersect, "Momentum", {0.2, 1.5}}, {}, "", {}, {}, true});
  const auto extracted = extract_scene(dataset, scene, nullptr, Task{});
  ASSERT_FALSE(extracted->mesh->tetrahedra.empty());
  EXPECT_GT(known(*extracted), 0.99);
}

TEST(ShadedBodies, ComeToAMeshThatIsThereAndCostNothingUnshaded) {
  const std::shared_ptr<const Dataset> dataset = make_analytic("torus:17", {}, Task{});
  const Scene off = one_layer(0.1, 0.4, 0), on = one_layer(0.1, 0.4, 0.5), more = one_layer(0.1, 0.4, 0.9);
  EXPECT_FALSE(same_extraction(off, on));
  EXPECT_TRUE(same_extraction(on, more));
  const auto plain = extract_scene(dataset, off, nullptr, Task{});
  EXPECT_FALSE(plain->body_normals);
  const auto shaded = extract_scene(dataset, on, plain, Task{});
  EXPECT_EQ(shaded->mesh, plain->mesh);
  EXPECT_GT(known(*shaded), 0.99);
  const auto again = extract_scene(dataset, off, shaded, Task{});
  EXPECT_EQ(again->mesh, plain->mesh);
  EXPECT_EQ(draw_input(*again, off, 16, 12).body_shading, 0);
}

TEST(ShadedBodies, AreDrawnFromAMesh) {
  const std::shared_ptr<const Dataset> boxes = make_analytic("torus:17", {}, Task{}), tets = make_analytic("tets:9", {}, Task{});
  BrickMemory bricks;
  BaseMeshes bases(std::uint64_t{1} << 30);
  SceneAids aids;
  aids.bricks = &bricks;
  aids.least_in_bricks = 0;
  aids.bases = &bases;
  aids.tetrahedra = TetrahedraWay::cut;
  for (const double shading : {0.0, 0.5})
    for (const auto& dataset : {boxes, tets}) {
      const PointArray& array = dataset->arrays[0];
      Scene scene = one_layer(array.lower + 0.2 * (array.upper - array.lower), array.lower + 0.5 * (array.upper - array.lower), shading);
      scene.array = array.name;
      const StepSource steps = [&](int, const Task&) { return dataset; };
      const auto extracted = extract_scene(steps, scene, nullptr, Task{}, aids);
      EXPECT_EQ(extracted->bricks || extracted->base, shading == 0) << dataset->name;
      EXPECT_EQ(known(*extracted) > 0.99, shading > 0) << dataset->name;
    }
}

TEST(ShadedBodies, WholeValuesHaveNoGradient) {
  const std::shared_ptr<const Dataset> dataset = make_analytic("torus:9", {}, Task{});
  Scene scene = one_layer(0.1, 0.4, 1);
  scene.values = FieldValues::whole;
  const auto extracted = extract_scene(dataset, scene, nullptr, Task{});
  EXPECT_FALSE(extracted->body_normals);
  EXPECT_EQ(draw_input(*extracted, scene, 16, 12).body_shading, 0);
}

TEST(ShadedBodies, ASmearHasThoseOfItsSteps) {
  Scene scene = one_layer(0.97, 0.99, 0.5);
  scene.array = "Density";
  scene.mode = SceneMode::smear;
  scene.smear.steps = {0, 2};
  const auto extracted = extract_scene(steps_of("cylinder:16x12x8x4"), scene, nullptr, Task{});
  EXPECT_EQ(extracted->parts.size(), 2u);
  EXPECT_GT(known(*extracted), 0.99);
}

}  // namespace
}  // namespace isostrata
