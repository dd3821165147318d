#include "import/limits/memory_limit.h"

#include <gtest/gtest.h>

#include "data/files.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;

TEST(MemoryLimit, GrowsWithTheFileAndNeverWraps) {
  std::uint64_t last = 0;
  for (const std::uint64_t stored : {0ull, 1ull, 24'000ull, 1ull << 20, 1ull << 40, 1ull << 62, ~0ull}) {
    EXPECT_GE(unpacked_bytes(stored), last);
    EXPECT_GE(unpacked_bytes(stored), stored);
    last = unpacked_bytes(stored);
  }
  EXPECT_LT(unpacked_bytes(24'000), kGiB);
}

TEST(MemoryLimit, IsThatOfTheFileAloneOrOfAllThatItMayName) {
  const test::Scratch scratch;
  const auto alone = scratch.write("in/a.vti", std::string(1000, 'a')), listing = scratch.write("in/a.pvd", std::string(10, 'a'));
  const std::uint64_t before = memory_limit(alone, kGiB * 1000);
  scratch.write("in/steps/b.raw", std::string(200'000, 'b'));
  EXPECT_EQ(memory_limit(alone, kGiB * 1000), before);
  EXPECT_LT(memory_limit(alone, kGiB * 1000), 2 * kGiB);
  EXPECT_GE(memory_limit(listing, kGiB * 1000), before);
  EXPECT_LE(memory_limit(listing, 1), memory_limit(listing, kGiB));
}

TEST(MemoryLimit, OfProcessorTimeGrowsWithTheFileToo) {
  const test::Scratch scratch;
  const auto small = scratch.write("in/a.vti", std::string(1000, 'a')), listing = scratch.write("in/a.pvd", std::string(10, 'a'));
  scratch.write("in/steps/b.raw", std::string(3 << 20, 'b'));
  EXPECT_EQ(cpu_limit(small, 600), 8u);
  EXPECT_EQ(cpu_limit(listing, 600), 20u);
  EXPECT_EQ(cpu_limit(listing, 15), 15u);
}

}  // namespace
}  // namespace isostrata
