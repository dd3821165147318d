#include "data/values/histogram.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "base/error.h"
#include "data/array_of.h"

namespace isostrata {
namespace {

using Counts = std::vector<std::uint64_t>;

TEST(Histogram, CountsEveryFiniteValueOnce) {
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  std::normal_distribution<float> normal;
  std::vector<float> values(700'000);
  for (float& value : values) value = normal(random);
  values[5] = std::nanf("");
  values[77] = std::numeric_limits<float>::infinity();
  for (const int bins : {1, 2, 17, 256}) {
    const Histogram h = histogram(array_of(values), bins);
    EXPECT_EQ(std::accumulate(h.counts.begin(), h.counts.end(), std::uint64_t{0}), values.size() - 2) << "seed " << kSeed;
  }
}

TEST(Histogram, BordersBelongToTheUpperBinAndTheMaximumToTheLast) {
  const std::vector<double> values{0, 1, 2, 3, 4};
  EXPECT_EQ(histogram(array_of(values), 4).counts, (Counts{1, 1, 1, 2}));
  const std::vector<std::uint8_t> bytes{0, 0, 128, 255};
  EXPECT_EQ(histogram(array_of(bytes), 255).counts[0], 2u);
  EXPECT_EQ(histogram(array_of(bytes), 255).counts[254], 1u);
}

TEST(Histogram, OfAConstantArrayHasAllInTheMiddle) {
  const std::vector<float> values(9, 3.5f);
  EXPECT_EQ(histogram(array_of(values), 5).counts, (Counts{0, 0, 9, 0, 0}));
}

TEST(Histogram, OfNothingFiniteIsEmpty) {
  const std::vector<float> values(9, std::nanf(""));
  EXPECT_EQ(histogram(array_of(values), 3).counts, (Counts{0, 0, 0}));
}

TEST(Histogram, SurvivesARangeAsWideAsDoublesAre) {
  const double most = std::numeric_limits<double>::max();
  const std::vector<double> values{-most, 0, most};
  EXPECT_EQ(histogram(array_of(values), 3).counts, (Counts{1, 1, 1}));
}

TEST(Histogram, OfAGivenRangeLeavesOutWhatIsOutside) {
  const std::vector<std::int16_t> values{-5, 0, 1, 2, 3, 9};
  EXPECT_EQ(histogram(array_of(values), 0, 2, 2), (Counts{1, 2}));
}

TEST(Histogram, RefusesBinsAndRangesThatMakeNoSense) {
  const std::vector<float> values{1, 2};
  EXPECT_THROW(histogram(array_of(values), 0), Error);
  EXPECT_THROW(histogram(array_of(values), -3), Error);
  EXPECT_THROW(histogram(array_of(values), (1 << 20) + 1), Error);
  EXPECT_THROW(histogram(array_of(values), 2, 1, 4), Error);
  EXPECT_THROW(histogram(array_of(values), std::nan(""), 1, 4), Error);
}

}  // namespace
}  // namespace isostrata
