#include "data/values/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "base/parallel.h"
#include "data/array_of.h"

namespace isostrata {
namespace {

TEST(Statistics, AgreeWithTwoPassesInLongDouble) {
  for (const double offset : {0.0, 1e9, -3.5e12}) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal(offset, 2.5);
    std::vector<double> values(300'001);
    for (double& v : values) v = normal(random);
    long double sum = 0, squares = 0;
    for (const double v : values) sum += v;
    const long double mean = sum / values.size();
    for (const double v : values) squares += (v - mean) * (v - mean);
    const Statistics s = statistics(array_of(values));
    EXPECT_NEAR(s.mean, static_cast<double>(mean), 1e-12 * std::max(1.0, std::abs(offset)));
    EXPECT_NEAR(s.standard_deviation, static_cast<double>(std::sqrt(squares / values.size())), 1e-6) << offset;
    EXPECT_EQ(s.finite, 300'001);
  }
}

TEST(Statistics, CountWhatIsNotFiniteAndLeaveItOut) {
  const float inf = std::numeric_limits<float>::infinity();
  const Statistics s = statistics(array_of<float>({1, NAN, 3, inf, -inf, NAN}));
  EXPECT_EQ(s.finite, 2);
  EXPECT_EQ(s.nan, 2);
  EXPECT_EQ(s.infinite, 2);
  EXPECT_EQ(s.mean, 2);
  EXPECT_EQ(s.standard_deviation, 1);
  const Statistics none = statistics(array_of<float>({NAN, inf}));
  EXPECT_EQ(none.finite, 0);
  EXPECT_GT(none.lower, none.upper);
}

TEST(Statistics, TheLargestDoublesDoNotOverflow) {
  const double most = std::numeric_limits<double>::max();
  const Statistics s = statistics(array_of<double>({most, -most}));
  EXPECT_NEAR(s.mean / most, 0, 1e-12);
  EXPECT_NEAR(s.standard_deviation / most, 1, 1e-12);
}

TEST(Statistics, DoNotDependOnTheNumberOfThreads) {
  std::mt19937 random(11);
  std::vector<float> values(500'000);
  for (float& v : values) v = static_cast<float>(random()) * 1e-3f;
  const PointArray array = array_of(values);
  const Statistics all = statistics(array);
  set_thread_count(1);
  const Statistics one = statistics(array);
  set_thread_count(0);
  EXPECT_EQ(all.mean, one.mean);
  EXPECT_EQ(all.standard_deviation, one.standard_deviation);
}

}  // namespace
}  // namespace isostrata
