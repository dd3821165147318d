#include "engine/data/dataset_store.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>

namespace isostrata {
namespace {

using namespace std::chrono_literals;

std::shared_ptr<const Dataset> made(const std::string& name, std::size_t floats) {
  auto storage = std::make_shared<std::vector<float>>(floats, 1.0f);
  auto dataset = std::make_shared<Dataset>();
  dataset->name = name;
  dataset->grid.shape = UniformGrid{{1, 1, 1}};
  PointArray array;
  array.values = std::span<const float>(*storage);
  array.storage = storage;
  dataset->arrays.push_back(array);
  return dataset;
}

TEST(DatasetStore, LoadsOnceHoweverManyAsk) {
  std::atomic<int> loads{0};
  DatasetStore store({}, [&](const std::string& source, int, const Task&, const auto&) {
    ++loads;
    std::this_thread::sleep_for(50ms);
    return made(source, 10);
  });
  std::vector<std::future<std::shared_ptr<const Dataset>>> asked;
  for (int i = 0; i < 8; ++i)
    asked.push_back(std::async(std::launch::async, [&] {
      const Task task;
      return store.acquire("a", 0, task);
    }));
  const auto first = asked[0].get();
  for (std::size_t i = 1; i < asked.size(); ++i) EXPECT_EQ(asked[i].get(), first);
  EXPECT_EQ(loads, 1);
}

TEST(DatasetStore, LoadingEndsOnlyWhenNobodyWaitsAnyMore) {
  std::atomic<bool> cancelled{false};
  std::atomic<bool> go{false};
  DatasetStore store({}, [&](const std::string& source, int, const Task& task, const auto&) {
    while (!go) {
      if (task.cancelled()) cancelled = true;
      task.check();
      std::this_thread::sleep_for(1ms);
    }
    return made(source, 10);
  });
  Task one, two;
  auto first = std::async(std::launch::async, [&] { return store.acquire("a", 0, one); });
  auto second = std::async(std::launch::async, [&] { return store.acquire("a", 0, two); });
  std::this_thread::sleep_for(50ms);
  one.cancel();
  EXPECT_THROW(first.get(), Error);
  EXPECT_FALSE(cancelled);
  go = true;
  EXPECT_TRUE(second.get());

  go = false;
  Task three;
  auto third = std::async(std::launch::async, [&] { return store.acquire("b", 0, three); });
  std::this_thread::sleep_for(50ms);
  three.cancel();
  EXPECT_THROW(third.get(), Error);
  for (int i = 0; i < 1000 && !cancelled; ++i) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(cancelled);
}

TEST(DatasetStore, DropsTheLeastRecentlyUsedThatNobodyHolds) {
  int loads = 0;
  DatasetStoreOptions options;
  options.max_bytes = 250 * sizeof(float);
  DatasetStore store(options, [&](const std::string& source, int, const Task&, const auto&) {
    ++loads;
    return made(source, 100);
  });
  const Task task;
  const auto held = store.acquire("held", 0, task);
  store.acquire("old", 0, task);
  store.acquire("new", 0, task);
  EXPECT_LE(store.held_bytes(), options.max_bytes);
  EXPECT_EQ(store.acquire("held", 0, task), held);
  store.acquire("new", 0, task);
  EXPECT_EQ(loads, 3) << "what is held and what is new is still there";
  store.acquire("old", 0, task);
  EXPECT_EQ(loads, 4);
}

TEST(DatasetStore, AFailureIsToldToEveryoneAndNotRemembered) {
  int loads = 0;
  DatasetStore store({}, [&](const std::string& source, int, const Task&, const auto&) -> std::shared_ptr<const Dataset> {
    if (++loads == 1) throw Error(ErrorCode::bad_data, "the first time it is broken");
    return made(source, 1);
  });
  const Task task;
  try {
    store.acquire("a", 0, task);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_data);
  }
  EXPECT_TRUE(store.acquire("a", 0, task));
}

TEST(DatasetStore, WhatIsBorrowedTakesNobodysPlace) {
  int loads = 0;
  DatasetStore store({.max_bytes = 100}, [&](const std::string& source, int, const Task&, const auto&) {
    ++loads;
    return made(source, 20);
  });
  const Task task;
  std::weak_ptr<const Dataset> borrowed = store.borrow("a", 1, task);
  EXPECT_TRUE(borrowed.expired());
  EXPECT_EQ(store.held_bytes(), 0u);
  const auto held = store.acquire("a", 1, task);
  EXPECT_EQ(store.borrow("a", 1, task), held);
  EXPECT_EQ(loads, 2);
}

/// A tetrahedron of its own memory, its last point at `x`, with the step's value at all points.
std::shared_ptr<const Dataset> tetrahedron(const std::string& name, int step, double x) {
  struct Parts {
    std::vector<Vec3d> points;
    std::vector<std::uint8_t> types{10};
    std::vector<std::int64_t> offsets{0, 4}, connectivity{0, 1, 2, 3};
  };
  auto parts = std::make_shared<Parts>();
  parts->points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {x, 0, 1}};
  auto dataset = std::make_shared<Dataset>(*made(name, 4));
  UnstructuredGrid shape;
  shape.points = std::span<const Vec3d>(parts->points);
  shape.types = parts->types;
  shape.offsets = parts->offsets;
  shape.connectivity = parts->connectivity;
  dataset->grid = {shape, {}, parts};
  dataset->step = step;
  dataset->times = {0, 1, 2, 3};
  return dataset;
}

TEST(DatasetStore, StepsOnOneMeshShareItAndOthersKeepTheirs) {
  DatasetStore store({}, [](const std::string& source, int step, const Task&, const auto&) { return tetrahedron(source, step, step == 2 ? 0.5 : 0); });
  const auto first = store.acquire("a", 0, Task()), second = store.acquire("a", 1, Task()), moved = store.acquire("a", 2, Task());
  const auto other = store.acquire("b", 0, Task());
  EXPECT_EQ(second->grid.storage, first->grid.storage);
  EXPECT_EQ(std::get<UnstructuredGrid>(second->grid.shape).connectivity.data(), std::get<UnstructuredGrid>(first->grid.shape).connectivity.data());
  EXPECT_EQ(second->step, 1);
  EXPECT_NE(second->arrays[0].storage, first->arrays[0].storage);
  EXPECT_NE(moved->grid.storage, first->grid.storage);
  EXPECT_NE(other->grid.storage, first->grid.storage) << "another source";
}

TEST(DatasetStore, AStepOnAMeshThatIsThereCountsByItsArrays) {
  DatasetStore store({}, [](const std::string& source, int step, const Task&, const auto&) { return tetrahedron(source, step, 0); });
  const auto first = store.acquire("a", 0, Task());
  const std::uint64_t one = store.held_bytes();
  const auto second = store.acquire("a", 1, Task());
  EXPECT_EQ(store.held_bytes(), one + 4 * sizeof(float));
}

TEST(DatasetStore, RoomForAStepIsHalfOfWhatIsLeftUnused) {
  DatasetStoreOptions options;
  options.max_bytes = 8 * 100 * sizeof(float);
  DatasetStore store(options, [](const std::string& source, int, const Task&, const auto&) { return made(source, 100); });
  const auto first = store.acquire("a", 0, Task());
  EXPECT_FALSE(store.has_room_for("a", 0)) << "it is there";
  EXPECT_TRUE(store.has_room_for("a", 1));
  const auto second = store.acquire("a", 1, Task()), third = store.acquire("a", 2, Task()), fourth = store.acquire("a", 3, Task());
  EXPECT_FALSE(store.has_room_for("a", 4));
}

}  // namespace
}  // namespace isostrata
