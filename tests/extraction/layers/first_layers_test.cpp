#include "extraction/layers/first_layers.h"

#include <gtest/gtest.h>

#include "data/dataset.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {
namespace {

std::shared_ptr<const Dataset> open(const char* name) { return open_dataset(name, {}, Task()); }

std::int64_t cells_cut(const Dataset& dataset, const std::vector<Interval>& layers) {
  return extract_intervals(dataset.grid, dataset.arrays[0], layers, {}, Task()).active_cells;
}

TEST(FirstLayers, CutASmallGridWholeIntoItsQuarters) {
  const auto dataset = open("torus:16");
  const PointArray& array = dataset->arrays[0];
  const auto layers = first_layers(dataset->grid, array, dataset->grid.cell_count(), Task());
  ASSERT_EQ(layers.size(), 4u);
  EXPECT_EQ(layers.front().lower, array.lower);
  EXPECT_EQ(layers.back().upper, array.upper);
  for (std::size_t i = 1; i < layers.size(); ++i) EXPECT_EQ(layers[i].lower, layers[i - 1].upper);
}

TEST(FirstLayers, KeepToHalfAgainTheBudgetInAllGridsWhereSomeLayersFit) {
  for (const char* name : {"torus:48", "sphere:48", "marschner-lobb:48", "cylinder:40x40x24", "tets:24", "mixed:24"}) {
    const auto dataset = open(name);
    const std::int64_t budget = dataset->grid.cell_count() / 4;
    const auto layers = first_layers(dataset->grid, dataset->arrays[0], budget, Task());
    ASSERT_FALSE(layers.empty()) << name;
    if (layers.size() > 1) {
      EXPECT_LE(cells_cut(*dataset, layers), budget + budget / 2) << name;
    }
    EXPECT_GT(cells_cut(*dataset, layers), 0) << name;
  }
}

TEST(FirstLayers, KeepOneLayerWhereNoneFits) {
  const auto dataset = open("torus:32");
  EXPECT_EQ(first_layers(dataset->grid, dataset->arrays[0], 1, Task()).size(), 1u);
}

TEST(FirstLayers, AreNoneForAConstantArray) {
  const auto dataset = open("torus:8");
  PointArray constant = dataset->arrays[0];
  constant.upper = constant.lower;
  EXPECT_TRUE(first_layers(dataset->grid, constant, 1000, Task()).empty());
}

TEST(FirstLayers, StopWhenCancelled) {
  const auto dataset = open("torus:32");
  Task task;
  task.cancel();
  EXPECT_THROW(first_layers(dataset->grid, dataset->arrays[0], 1, task), Error);
}

}  // namespace
}  // namespace isostrata
