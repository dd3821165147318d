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
  DatasetStore store({}, [&](const std::string& source, int, const Task&) {
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
  DatasetStore store({}, [&](const std::string& source, int, const Task& task) {
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
  DatasetStore store(options, [&](const std::string& source, int, const Task&) {
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
  DatasetStore store({}, [&](const std::string& source, int, const Task&) -> std::shared_ptr<const Dataset> {
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
  DatasetStore store({.max_bytes = 100}, [&](const std::string& source, int, const Task&) {
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

}  // namespace
}  // namespace isostrata
