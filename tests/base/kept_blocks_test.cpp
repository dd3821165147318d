#include "base/kept_blocks.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <thread>
#include <vector>

#include "base/buffer.h"

namespace isostrata {
namespace {

class KeptBlocks : public ::testing::Test {
 protected:
  void SetUp() override {
    free_kept_blocks();
    void* const at = take_block(kHugePage);
    give_block(at, kHugePage);
    if (kept_bytes() == 0) GTEST_SKIP() << "nothing is kept under a sanitizer";
    free_kept_blocks();
  }
  void TearDown() override {
    keep_at_most(kMostKept);
    free_kept_blocks();
  }
};

TEST_F(KeptBlocks, WhatWasFreedIsTakenAgainBySizesThatAreNearlyTheSame) {
  const std::size_t bytes = 37 << 20;
  void* const first = take_block(bytes);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(first) % kHugePage, 0u);
  std::memset(first, 7, bytes);
  give_block(first, bytes);
  EXPECT_GE(kept_bytes(), bytes);
  void* const other = take_block(bytes / 2);
  EXPECT_NE(other, first);
  void* const again = take_block(bytes + 4096);
  EXPECT_EQ(again, first);
  EXPECT_EQ(kept_bytes(), 0u);
  std::memset(again, 9, bytes + 4096);
  give_block(again, bytes + 4096);
  give_block(other, bytes / 2);
}

TEST_F(KeptBlocks, NoMoreIsKeptThanTheMostAndTheOldestGoesFirst) {
  const std::size_t bytes = 40 << 20;
  std::vector<void*> blocks;
  for (int i = 0; i < 12; ++i) blocks.push_back(take_block(bytes));
  for (void* const at : blocks) {
    give_block(at, bytes);
    EXPECT_LE(kept_bytes(), kMostKept);
  }
  EXPECT_EQ(take_block(bytes), blocks.back());
  give_block(blocks.back(), bytes);
  void* const large = take_block(2 * kMostKept);  // never touched, never kept
  const std::size_t before = kept_bytes();
  give_block(large, 2 * kMostKept);
  EXPECT_EQ(kept_bytes(), before);
}

TEST_F(KeptBlocks, WhoHasLittleMemoryKeepsLess) {
  const std::size_t bytes = 4 << 20;
  std::vector<void*> blocks;
  for (int i = 0; i < 6; ++i) blocks.push_back(take_block(bytes));
  for (void* const at : blocks) give_block(at, bytes);
  EXPECT_EQ(kept_bytes(), 6 * bytes);
  keep_at_most(3 * bytes);
  EXPECT_EQ(kept_bytes(), 3 * bytes);
  EXPECT_EQ(take_block(bytes), blocks.back()) << "the newest stay";
  give_block(blocks.back(), bytes);
  void* const larger = take_block(4 * bytes);
  give_block(larger, 4 * bytes);
  EXPECT_EQ(kept_bytes(), 3 * bytes) << "what is larger than all that may be kept drives nothing out";
  keep_at_most(2 * kMostKept);
  blocks = {take_block(200 << 20), take_block(200 << 20)};  // never touched
  for (void* const at : blocks) give_block(at, 200 << 20);
  EXPECT_LE(kept_bytes(), kMostKept);
}

TEST_F(KeptBlocks, BuffersOfManyThreadsNeverShareOne) {
  std::vector<std::thread> threads;
  for (std::uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([t] {
      for (std::uint32_t i = 0; i < 50; ++i) {
        Buffer<std::uint32_t> buffer((kHugePage >> 2) + 1000 * i);
        for (std::size_t k = 0; k < buffer.size(); k += 512) buffer[k] = t << 16 | i;
        std::this_thread::yield();
        for (std::size_t k = 0; k < buffer.size(); k += 512) ASSERT_EQ(buffer[k], t << 16 | i);
      }
    });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace isostrata
