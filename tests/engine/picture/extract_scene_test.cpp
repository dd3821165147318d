#include "engine/picture/extract_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "engine/two_layers.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;

using ExtractScene = TwoLayers;

TEST_F(ExtractScene, ExtractsWhatExtractIntervalsExtracts) {
  const auto extracted = extract(scene());
  const std::vector<Interval> ends{{1.0, 1.5}, {1.5, 2.0}};
  const IntervalMesh mesh = extract_intervals(dataset_->grid, dataset_->arrays[0], ends, {}, Task{});
  EXPECT_EQ(extracted->mesh->tetrahedra, mesh.tetrahedra);
  EXPECT_EQ(extracted->array, dataset_->arrays[0].name);
  EXPECT_EQ(extracted->color_values, nullptr);
  EXPECT_GT(extracted->extract_ms, 0);
}

TEST_F(ExtractScene, InvisibleIntervalsAreExtractedToo) {
  Scene hidden = scene();
  hidden.intervals[0].visible = false;
  EXPECT_EQ(extract(hidden)->mesh->tetrahedra, extract(scene())->mesh->tetrahedra);
}

TEST_F(ExtractScene, ReusesTheMeshWhereOnlyLooksChanged) {
  Scene changed = scene();
  const auto first = extract(changed);
  changed.intervals[0].color = {0, 1, 1};
  changed.intervals[1].opacity = 0.9;
  changed.intervals[1].visible = false;
  changed.mode = SceneMode::prioritized;
  changed.camera = Camera{};
  changed.unit_distance = 3;
  const auto second = extract(changed, first);
  EXPECT_EQ(second->mesh, first->mesh);
  EXPECT_EQ(second->extract_ms, 0);
  EXPECT_EQ(extract(changed, second), second);
}

TEST_F(ExtractScene, CarriesColoursOnceTheyAreWantedAndKeepsTheMesh) {
  Scene colored = scene();
  const auto plain = extract(colored);
  colored.intervals[0].color_map = "viridis";
  const auto by_itself = extract(colored, plain);
  EXPECT_EQ(by_itself->mesh, plain->mesh);
  ASSERT_TRUE(by_itself->color_values);
  EXPECT_EQ(by_itself->color_values->size(), plain->mesh->positions.size());
  for (std::size_t p = 0; p < by_itself->color_values->size(); ++p)
    ASSERT_NEAR((*by_itself->color_values)[p], plain->mesh->values[p], 1e-4) << "point " << p;

  colored.color_by = dataset_->arrays[1].name;
  const auto by_other = extract(colored, by_itself);
  EXPECT_EQ(by_other->mesh, plain->mesh);
  EXPECT_NE(by_other->color_values, by_itself->color_values);
  EXPECT_EQ(by_other->color_lower, dataset_->arrays[1].lower);
  EXPECT_EQ(by_other->color_upper, dataset_->arrays[1].upper);
  EXPECT_EQ(extract(colored, by_other)->color_values, by_other->color_values);
}

TEST_F(ExtractScene, ExtractsAnewWhereTheMeshWouldDiffer) {
  const auto first = extract(scene());
  Scene other = scene();
  other.intervals[1].upper = 2.1;
  EXPECT_NE(extract(other, first)->mesh, first->mesh);
  other = scene();
  other.intervals.pop_back();
  EXPECT_NE(extract(other, first)->mesh, first->mesh);
  other = scene();
  other.array = dataset_->arrays[1].name;
  EXPECT_NE(extract(other, first)->mesh, first->mesh);
  const auto again = extract_scene(make_analytic("cylinder:12x10x8", {}, Task{}), scene(), first, Task{});
  EXPECT_NE(again->mesh, first->mesh);
}

TEST_F(ExtractScene, ASceneWithoutIntervalsIsEmpty) {
  Scene empty = scene();
  empty.intervals.clear();
  const auto extracted = extract(empty);
  EXPECT_TRUE(extracted->mesh->tetrahedra.empty());
  EXPECT_EQ(extracted->mesh->cells, dataset_->grid.cell_count());
}

TEST_F(ExtractScene, TakesTheFirstArrayWhereNoneIsNamedAndSaysWhichIsMissing) {
  Scene unnamed = scene();
  unnamed.array.clear();
  EXPECT_EQ(extract(unnamed)->array, dataset_->arrays[0].name);
  unnamed.array = "nosuch";
  try {
    extract(unnamed);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::not_found);
    EXPECT_THAT(error.what(), HasSubstr("nosuch"));
  }
  Scene uncolored = scene();
  uncolored.color_by = "nothere";
  EXPECT_THROW(extract(uncolored), Error);
}

TEST_F(ExtractScene, RefusesEndsThatAreNoInterval) {
  Scene bad = scene();
  bad.intervals[0].upper = bad.intervals[0].lower;
  EXPECT_THROW(extract(bad), Error);
}

TEST_F(ExtractScene, StopsWhenItIsCancelled) {
  Task task;
  task.cancel();
  try {
    extract_scene(dataset_, scene(), nullptr, task);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

}  // namespace
}  // namespace isostrata
