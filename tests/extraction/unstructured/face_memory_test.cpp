#include "extraction/unstructured/face_memory.h"

#include <gtest/gtest.h>

#include <random>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kMuch = std::uint64_t{1} << 30;

/// Of wedges, pyramids and other cells.
std::shared_ptr<const Dataset> mixed() { return make_analytic("mixed:12", {}, Task{}); }

/// Its first array, as if some value were none.
PointArray with_nan(const Dataset& dataset) {
  PointArray array = dataset.arrays[0];
  array.nan_count = 1;
  return array;
}

void expect_same(const IntervalMesh& a, const IntervalMesh& b, const std::string& what) {
  ASSERT_FALSE(a.facets.empty()) << what;
  ASSERT_EQ(a.facets.size(), b.facets.size()) << what;
  for (std::size_t f = 0; f < a.facets.size(); ++f) {
    ASSERT_EQ(a.facets[f].points, b.facets[f].points) << what;
    ASSERT_EQ(a.facets[f].tetrahedron, b.facets[f].tetrahedron) << what;
    ASSERT_EQ(a.facets[f].label, b.facets[f].label) << what;
  }
}

TEST(FaceMemory, WhatIsKnownChangesNoFacet) {
  const auto dataset = mixed();
  const PointArray& array = dataset->arrays[0];
  Grid holed = dataset->grid;  // some cells are hidden
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(holed.cell_count()));
  std::mt19937 random(7);
  for (auto& cell : hidden) cell = random() % 5 == 0;
  holed.hidden_cells = hidden;
  for (const Grid* grid : {&dataset->grid, &std::as_const(holed)}) {
    FaceMemory memory(kMuch);
    memory.make(*grid, Task{});
    ASSERT_TRUE(memory.find(*grid, array));
    for (int i = 0; i < 20; ++i) {
      std::uniform_real_distribution<double> any(array.lower, array.upper);
      const double a = any(random), b = any(random);
      const std::vector<Interval> intervals{{std::min(a, b), std::max(a, b)}};
      ExtractOptions options;
      options.facets = true;
      const IntervalMesh plain = extract_intervals(*grid, array, intervals, options, Task{});
      options.faces = &memory;
      expect_same(plain, extract_intervals(*grid, array, intervals, options, Task{}), "interval " + std::to_string(i));
    }
  }
}

TEST(FaceMemory, KnowsAGridAsLongAsItIsThere) {
  FaceMemory memory(kMuch);
  auto dataset = mixed();
  EXPECT_FALSE(memory.knows(dataset->grid));
  EXPECT_FALSE(memory.find(dataset->grid, dataset->arrays[0]));
  memory.make(dataset->grid, Task{});
  EXPECT_TRUE(memory.knows(dataset->grid));
  EXPECT_EQ(memory.bytes(), static_cast<std::uint64_t>(dataset->grid.cell_count()));
  EXPECT_FALSE(memory.find(dataset->grid, with_nan(*dataset))) << "cells may be absent";
  const auto other = mixed();
  EXPECT_FALSE(memory.knows(other->grid));
  dataset.reset();
  memory.make(other->grid, Task{});
  EXPECT_EQ(memory.bytes(), static_cast<std::uint64_t>(other->grid.cell_count())) << "the first is forgotten";
}

}  // namespace
}  // namespace isostrata
