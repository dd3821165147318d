#include "extraction/mesh/interval_mesh.h"

#include <gtest/gtest.h>

#include <random>

namespace isostrata {
namespace {

TEST(PointOrigin, GivesBackWhatItWasMadeFrom) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto a = static_cast<std::int64_t>(random() >> (17 + random() % 47));  // below 2^47
    const auto b = static_cast<std::int64_t>(random() >> (17 + random() % 47));
    const float weight = std::uniform_real_distribution<float>(0, 1)(random);
    const PointOrigin origin(a, b, weight);
    ASSERT_EQ(origin.a(), a) << "seed 1, origin " << i;
    ASSERT_EQ(origin.b(), b) << "seed 1, origin " << i;
    ASSERT_EQ(origin.weight(), weight) << "seed 1, origin " << i;
  }
  EXPECT_EQ(sizeof(PointOrigin), 16u);
}

TEST(Buffer, IsAVectorThatDoesNotTouchWhatItWillNotKeep) {
  Buffer<int> small(3), large(3 << 20);
  large.front() = 1;
  large.back() = 2;
  small.assign(5, 7);
  small.push_back(8);
  EXPECT_EQ(small, (Buffer<int>{7, 7, 7, 7, 7, 8}));
  const Buffer<int> copy = large;
  EXPECT_EQ(copy.size(), std::size_t{3} << 20);
  EXPECT_EQ(copy.back(), 2);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(copy.data()) % (2 << 20), 0u) << "large ones lie in huge pages";
}

}  // namespace
}  // namespace isostrata
