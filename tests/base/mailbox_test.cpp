#include "base/mailbox.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

namespace isostrata {
namespace {

TEST(Mailbox, HoldsNothingAtFirst) {
  Mailbox<int> box;
  EXPECT_EQ(box.try_take(), std::nullopt);
}

TEST(Mailbox, GivesAValueOnce) {
  Mailbox<int> box;
  EXPECT_TRUE(box.put(7));
  EXPECT_EQ(box.try_take(), 7);
  EXPECT_EQ(box.try_take(), std::nullopt);
}

TEST(Mailbox, KeepsOnlyTheNewest) {
  Mailbox<int> box;
  for (int i = 1; i <= 5; ++i) box.put(i);
  EXPECT_EQ(box.take(), 5);
  EXPECT_EQ(box.try_take(), std::nullopt);
}

TEST(Mailbox, DropsWhatItReplacesAtOnce) {
  Mailbox<std::shared_ptr<int>> box;
  const auto first = std::make_shared<int>(1);
  box.put(first);
  EXPECT_EQ(first.use_count(), 2);
  box.put(std::make_shared<int>(2));
  EXPECT_EQ(first.use_count(), 1);
}

TEST(Mailbox, TakesWhatCanOnlyBeMoved) {
  Mailbox<std::unique_ptr<int>> box;
  box.put(std::make_unique<int>(3));
  EXPECT_EQ(**box.take(), 3);
}

TEST(Mailbox, RefusesValuesOnceClosed) {
  Mailbox<int> box;
  box.close();
  EXPECT_FALSE(box.put(1));
  EXPECT_EQ(box.take(), std::nullopt);
}

TEST(Mailbox, GivesTheLastValueEvenAfterItIsClosed) {
  Mailbox<int> box;
  box.put(9);
  box.close();
  EXPECT_EQ(box.take(), 9);
  EXPECT_EQ(box.take(), std::nullopt);
}

TEST(Mailbox, ClosingWakesEveryoneWhoWaits) {
  Mailbox<int> box;
  std::optional<int> a = 1, b = 1;
  std::thread first([&] { a = box.take(); });
  std::thread second([&] { b = box.take(); });
  box.close();
  first.join();
  second.join();
  EXPECT_EQ(a, std::nullopt);
  EXPECT_EQ(b, std::nullopt);
}

// Whatever is skipped, the order is kept and the last value arrives.
TEST(Mailbox, AReaderSeesGrowingValuesAndTheLastOne) {
  constexpr int kLast = 20000;
  Mailbox<int> box;
  std::thread writer([&] {
    for (int i = 1; i <= kLast; ++i) box.put(i);
    box.close();
  });
  int newest = 0;
  bool grows = true;
  while (const auto value = box.take()) {
    grows = grows && *value > newest;
    newest = *value;
  }
  writer.join();
  EXPECT_TRUE(grows);
  EXPECT_EQ(newest, kLast);
}

TEST(Mailbox, EachValueGoesToOneReaderOfMany) {
  constexpr int kValues = 5000;
  Mailbox<int> box;
  std::vector<int> seen[3];
  std::vector<std::thread> readers;
  for (auto& mine : seen)
    readers.emplace_back([&] {
      while (const auto value = box.take()) mine.push_back(*value);
    });
  for (int i = 0; i < kValues; ++i) box.put(i);
  box.close();
  for (auto& reader : readers) reader.join();
  std::vector<int> times_seen(kValues, 0);
  for (const auto& mine : seen)
    for (int value : mine) ++times_seen[static_cast<std::size_t>(value)];
  EXPECT_LE(*std::max_element(times_seen.begin(), times_seen.end()), 1);
  EXPECT_EQ(times_seen.back(), 1);
}

}  // namespace
}  // namespace isostrata
