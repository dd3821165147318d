#include "data/derived/scaled_dataset.h"

#include <gtest/gtest.h>

#include <array>
#include <barrier>
#include <memory>
#include <thread>
#include <vector>

#include "data/dataset/analytic.h"
#include "data/dataset/dataset.h"

namespace isostrata {
namespace {

constexpr Vec3d kFactors{2, 0.5, 30};

std::shared_ptr<const Dataset> dataset_of(const char* name) { return make_analytic(name, {}, Task{}); }

/// The same points, of a kind of grid that has each of them.
std::shared_ptr<Dataset> curvilinear(const Dataset& of) {
  auto points = std::make_shared<std::vector<Vec3d>>();
  for (std::int64_t id = 0; id < of.grid.point_count(); ++id) points->push_back(of.grid.point(id));
  auto out = std::make_shared<Dataset>(of);
  out->grid.shape = CurvilinearGrid{of.grid.dims(), std::span<const Vec3d>(*points)};
  out->grid.storage = points;
  return out;
}

std::shared_ptr<Dataset> rectilinear(const Dataset& of) {
  auto out = std::make_shared<Dataset>(of);
  RectilinearGrid grid{of.grid.dims(), {}};
  std::int64_t stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::int64_t i = 0; i < grid.dims[static_cast<std::size_t>(axis)]; ++i)
      grid.axes[static_cast<std::size_t>(axis)].push_back(of.grid.point(i * stride)[axis]);
    stride *= grid.dims[static_cast<std::size_t>(axis)];
  }
  out->grid.shape = grid;
  return out;
}

TEST(ScaledDataset, HasEachPointAtItsPlaceTimesTheFactors) {
  const auto torus = dataset_of("torus:7");
  for (const auto& dataset : {torus, std::shared_ptr<const Dataset>(curvilinear(*torus)), std::shared_ptr<const Dataset>(rectilinear(*torus)), dataset_of("tets:5")}) {
    const Dataset scaled = scaled_dataset(*dataset, kFactors);
    ASSERT_EQ(scaled.grid.point_count(), dataset->grid.point_count());
    EXPECT_EQ(scaled.grid.shape.index(), dataset->grid.shape.index());
    for (std::int64_t id = 0; id < dataset->grid.point_count(); ++id) {
      const Vec3d from = dataset->grid.point(id), to = scaled.grid.point(id);
      for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(to[axis], from[axis] * kFactors[axis], 1e-6 * kFactors[axis]);
    }
    const Box3d bounds = scaled.grid.bounds();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(scaled.bounds.lower[axis], bounds.lower[axis], 1e-6 * kFactors[axis]);
      EXPECT_NEAR(scaled.bounds.upper[axis], bounds.upper[axis], 1e-6 * kFactors[axis]);
    }
    EXPECT_EQ(scaled.arrays.front().storage, dataset->arrays.front().storage) << "values are not copied";
  }
}

TEST(ScaledDataset, LivesLongerThanItsOriginal) {
  auto points = curvilinear(*dataset_of("torus:5"));
  const Vec3d last = points->grid.point(124);
  const Dataset scaled = scaled_dataset(*points, kFactors);
  points.reset();
  EXPECT_EQ(scaled.grid.point(124).z, last.z * kFactors.z);
}

TEST(ScaledDatasets, AreMadeOnceAndOfStepsOnOneMeshTheMeshIs) {
  ScaledDatasets scaled;
  const std::shared_ptr<const Dataset> first = curvilinear(*dataset_of("torus:5"));
  auto other_step = std::make_shared<Dataset>(*first);
  other_step->step = 1;
  EXPECT_EQ(scaled.scaled(first, {1, 1, 1}), first);
  const auto a = scaled.scaled(first, kFactors);
  EXPECT_EQ(scaled.scaled(first, kFactors), a);
  EXPECT_NE(scaled.scaled(first, {1, 1, 2}), a);
  const auto b = scaled.scaled(other_step, kFactors);
  EXPECT_NE(b, a);
  EXPECT_EQ(b->grid.storage, a->grid.storage);
  EXPECT_NE(a->grid.storage, first->grid.storage) << "whoever knows meshes by it must not take one for the other";
  EXPECT_EQ(b->step, 1);
}

TEST(ScaledDatasets, OfAllWhoAskAtOnceEachGetsTheSame) {
  const std::shared_ptr<const Dataset> first = curvilinear(*dataset_of("torus:17"));
  auto other_step = std::make_shared<Dataset>(*first);
  other_step->step = 1;
  for (int round = 0; round < 20; ++round) {
    ScaledDatasets scaled;
    constexpr int kThreads = 6;
    std::array<std::shared_ptr<const Dataset>, kThreads> got;
    std::barrier together(kThreads);
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i)
      threads.emplace_back([&, i] {
        together.arrive_and_wait();
        got[static_cast<std::size_t>(i)] = scaled.scaled(i % 2 ? other_step : first, kFactors);
      });
    threads.clear();
    for (std::size_t i = 0; i < kThreads; ++i) {
      EXPECT_EQ(got[i], got[i % 2]);
      EXPECT_EQ(got[i]->grid.storage, got[0]->grid.storage) << "steps on one mesh stay on one mesh";
    }
  }
}

TEST(ScaledDatasets, KeepWhatTheyAreMadeOfAsLongAsTheyAreHeld) {
  ScaledDatasets scaled;
  std::weak_ptr<const Dataset> original;
  std::shared_ptr<const Dataset> held;
  {
    const std::shared_ptr<const Dataset> dataset = curvilinear(*dataset_of("torus:5"));
    original = dataset;
    held = scaled.scaled(dataset, kFactors);
  }
  EXPECT_FALSE(original.expired()) << "another dataset at its place would be taken for it";
  held.reset();
  EXPECT_TRUE(original.expired());
}

TEST(ScaledRegions, PartWhatTheRegionsParted) {
  const auto torus = dataset_of("torus:9");
  const RegionTree regions = make_regions(torus->grid, 5), scaled = scaled_regions(regions, kFactors);
  const Dataset drawn = scaled_dataset(*torus, kFactors);
  for (std::int64_t id = 0; id < torus->grid.point_count(); ++id) {
    const Vec3d inside = torus->grid.point(id) + Vec3d{1e-3, 1e-3, 1e-3};
    EXPECT_EQ(region_at(scaled, {inside.x * kFactors.x, inside.y * kFactors.y, inside.z * kFactors.z}), region_at(regions, inside));
  }
}

}  // namespace
}  // namespace isostrata
