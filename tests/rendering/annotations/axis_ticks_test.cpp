#include "rendering/annotations/axis_ticks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>

namespace isostrata {
namespace {

TEST(AxisTicks, AreFewRoundAndWithinTheRange) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> mantissa(-10, 10), exponent(-12, 12);
  for (int trial = 0; trial < 2000; ++trial) {
    const double a = mantissa(random) * std::pow(10, exponent(random)), b = a + std::pow(10, exponent(random));
    if (!(b - a > 1e-9 * std::max(std::abs(a), std::abs(b)))) continue;
    const int most = 2 + trial % 9;
    const AxisTicks ticks = axis_ticks(a, b, most);
    ASSERT_LE(ticks.values.size(), static_cast<std::size_t>(most)) << "trial " << trial << ", seed 11";
    ASSERT_FALSE(ticks.values.empty()) << a << ".." << b;
    const double lead = ticks.step / std::pow(10, std::floor(std::log10(ticks.step) + 1e-9));
    EXPECT_TRUE(std::abs(lead - 1) < 1e-6 || std::abs(lead - 2) < 1e-6 || std::abs(lead - 5) < 1e-6) << ticks.step;
    for (const double value : ticks.values) {
      EXPECT_GE(value, a - 1e-8 * ticks.step);  // an end that is round but for its last digits is a tick
      EXPECT_LE(value, b + 1e-8 * ticks.step);
    }
    const auto texts = tick_texts(ticks);
    EXPECT_EQ(std::set<std::string>(texts.begin(), texts.end()).size(), texts.size()) << a << ".." << b << ": " << texts[0];
  }
}

TEST(AxisTicks, EndsOfTheRangeAreTicksWhereTheyAreRound) {
  EXPECT_EQ(axis_ticks(-1, 1, 5).values, (std::vector<double>{-1, -0.5, 0, 0.5, 1}));
  EXPECT_EQ(axis_ticks(0, 0.3, 4).values.size(), 4u);
}

TEST(AxisTicks, EmptyAndEndlessRangesHaveNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const auto& [a, b] : {std::pair{1.0, 1.0}, {2.0, 1.0}, {nan, 1.0}, {0.0, inf}, {1.0, 1.0 + 1e-15}, {-1.7e308, 1.7e308}})
    EXPECT_TRUE(axis_ticks(a, b, 5).values.empty()) << a << ".." << b;
}

TEST(TickTexts, HaveAsManyDecimalsAsTheStepNeeds) {
  EXPECT_EQ(tick_texts(axis_ticks(-1, 1, 5)), (std::vector<std::string>{"\u22121.0", "\u22120.5", "0.0", "0.5", "1.0"}));
  EXPECT_EQ(tick_texts(axis_ticks(0, 20000, 3)), (std::vector<std::string>{"0", "10000", "20000"}));
  EXPECT_EQ(tick_texts(axis_ticks(0, 3e-7, 4)),
            (std::vector<std::string>{"0", "1\u00d710\u207b\u2077", "2\u00d710\u207b\u2077", "3\u00d710\u207b\u2077"}));
  EXPECT_EQ(tick_texts(axis_ticks(1.0e9, 1.2e9, 3)),
            (std::vector<std::string>{"1.0\u00d710\u2079", "1.1\u00d710\u2079", "1.2\u00d710\u2079"}));
}

TEST(NumberText, IsShort) {
  EXPECT_EQ(number_text(0.25), "0.25");
  EXPECT_EQ(number_text(-3), "\u22123");
  EXPECT_EQ(number_text(1234567.0), "1.235\u00d710\u2076");
  EXPECT_EQ(number_text(9.99996e5), "1\u00d710\u2076");
  EXPECT_EQ(number_text(0.1 + 0.2), "0.3");
  EXPECT_EQ(number_text(1e-9), "1\u00d710\u207b\u2079");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(std::numeric_limits<double>::infinity()), "\u221e");
}

}  // namespace
}  // namespace isostrata
