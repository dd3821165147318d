// Scenes of whole values: what they are drawn from, and that the picture is that of the cells.
#include <gtest/gtest.h>

#include <set>

#include "data/dataset/analytic.h"
#include "engine/picture/coarse_scene.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/interval_facts.h"
#include "extraction/bricks/brick_memory.h"
#include "rendering/choice/native_renderer.h"

namespace isostrata {
namespace {

/// Cells of a box with the labels 1, 2, 5 in slabs along x, and the means at its points, as the importer makes them.
std::shared_ptr<const Dataset> labelled() {
  auto dataset = std::make_shared<Dataset>(*make_analytic("torus:9", {}, Task()));
  const std::int64_t cells = dataset->grid.cell_count(), points = dataset->grid.point_count();
  auto labels = std::make_shared<std::vector<std::int32_t>>(static_cast<std::size_t>(cells));
  constexpr std::array<std::int32_t, 8> kAlongX{1, 1, 5, 5, 2, 2, 2, 1};
  for (std::size_t c = 0; c < labels->size(); ++c) (*labels)[c] = kAlongX[c % 8];
  CellValues of{ScalarType::int32, std::span<const std::int32_t>(*labels), 0, 0, 0, labels};
  measure_range(of);
  PointArray array;
  array.name = "label";
  array.association = Association::cell_averaged;
  auto means = std::make_shared<std::vector<float>>(static_cast<std::size_t>(points), 2.5f);
  array.values = std::span<const float>(*means);
  array.storage = means;
  measure_range(array);
  array.cells = std::make_shared<const CellValues>(of);
  dataset->arrays.push_back(array);
  return dataset;
}

Scene scene_of(const std::string& array, std::vector<Interval> intervals) {
  Scene scene;
  scene.array = array;
  scene.values = FieldValues::whole;
  for (const Interval& ends : intervals) {
    SceneInterval interval;
    interval.id = static_cast<std::uint32_t>(scene.intervals.size() + 1);
    interval.lower = ends.lower;
    interval.upper = ends.upper;
    interval.color = default_interval_color(scene.intervals.size());
    scene.intervals.push_back(interval);
  }
  return scene;
}

SceneAids native_aids(BrickMemory& bricks) {
  SceneAids aids;
  aids.bricks = &bricks;
  aids.least_in_bricks = 0;
  return aids;
}

std::shared_ptr<const ExtractedScene> extract_with(const std::shared_ptr<const Dataset>& dataset, const Scene& scene, const SceneAids& aids,
                                                   const std::shared_ptr<const ExtractedScene>& previous = nullptr) {
  return extract_scene([&](int, const Task&) { return dataset; }, scene, previous, Task(), aids);
}

Image picture_of(const ExtractedScene& extracted, const Scene& scene) {
  const auto renderer = make_native_renderer();
  const DrawInput input = draw_input(extracted, scene, 96, 72);
  return std::get<Image>(renderer->draw(input).image);
}

TEST(WholeScene, FacetsAloneGiveThePictureOfTheTetrahedra) {
  const auto dataset = labelled();
  BrickMemory bricks;
  for (const char* array : {"label", "distance"}) {
    Scene scene = scene_of(array, {{0.1, 0.3}, {1.5, 2.5}, {4, 6}});
    if (std::string(array) == "distance") scene.intervals = scene_of(array, {{0.1, 0.3}, {0.35, 0.5}}).intervals;
    for (const bool lit : {false, true}) {
      if (lit) scene.intervals.front().surface.lower = scene.intervals.front().surface.domain = true;
      const auto full = extract_with(dataset, scene, {}), facets = extract_with(dataset, scene, native_aids(bricks));
      EXPECT_FALSE(full->mesh->tetrahedra.empty());
      EXPECT_TRUE(facets->mesh->tetrahedra.empty());
      EXPECT_FALSE(facets->bricks);
      EXPECT_EQ(picture_of(*full, scene).rgba, picture_of(*facets, scene).rgba) << array << (lit ? ", lit" : "");
    }
  }
}

TEST(WholeScene, ColoursOfCellsDoNotRun) {
  const auto dataset = labelled();
  Scene scene = scene_of("label", {{0, 9}});
  scene.intervals[0].color_map = "viridis";
  const auto extracted = extract_with(dataset, scene, {});
  ASSERT_TRUE(extracted->color_values);
  EXPECT_EQ(extracted->color_lower, 1);
  EXPECT_EQ(extracted->color_upper, 5) << "the cells' range, not the means'";
  EXPECT_EQ(std::set<float>(extracted->color_values->begin(), extracted->color_values->end()), (std::set<float>{1, 2, 5}));
  for (const auto& t : extracted->mesh->tetrahedra)
    for (const std::uint32_t p : t) ASSERT_EQ((*extracted->color_values)[p], (*extracted->color_values)[t[0]]);
  // By an array of points they do, also from a mesh whose cells have points of their own.
  scene.color_by = "distance";
  const auto by_points = extract_with(dataset, scene, {}, extracted);
  EXPECT_GT(std::set<float>(by_points->color_values->begin(), by_points->color_values->end()).size(), 20u);
  scene.intervals[0].color_map.clear();
  scene.color_by.clear();
  EXPECT_FALSE(extract_with(dataset, scene, {}, by_points)->color_values);
}

TEST(WholeScene, IsAnotherOneThanTheInterpolatedAndSaysItsCellsExactly) {
  const auto dataset = labelled();
  Scene scene = scene_of("label", {{3, 4}, {4.5, 5.5}});
  const auto whole = extract_with(dataset, scene, {});
  EXPECT_EQ(whole->summaries()[0].tetrahedra, 0);
  EXPECT_EQ(whole->summaries()[1].active_cells, 2 * 64);
  const auto facts = interval_facts(*whole, scene, true, Task());
  const Vec3d size = dataset->bounds.upper - dataset->bounds.lower;
  EXPECT_EQ(facts[1].volume_error, 0.0);
  EXPECT_NEAR(facts[1].volume, 0.25 * size.x * size.y * size.z, 1e-9);
  EXPECT_EQ(extract_with(dataset, scene, {}, whole)->mesh, whole->mesh) << "nothing is extracted again";
  scene.values = FieldValues::interpolated;
  const auto between = extract_with(dataset, scene, {}, whole);
  EXPECT_NE(between->mesh, whole->mesh);
}

TEST(WholeScene, HasNoCoarserPictureOfCellsAndOneOfPoints) {
  const auto dataset = make_analytic("torus:80", {}, Task());
  CoarseScenes coarse(0);
  Scene scene = scene_of("distance", {{0.1, 0.3}});
  const auto moving = coarse.extract_for_motion(dataset, scene, 1, Task());
  ASSERT_TRUE(moving);
  EXPECT_GT(moving->point_stride, 1);
  auto cells = std::make_shared<Dataset>(*dataset);
  cells->arrays.front().association = Association::cell_averaged;
  EXPECT_FALSE(coarse.extract_for_motion(cells, scene, 1, Task()));
}

}  // namespace
}  // namespace isostrata
