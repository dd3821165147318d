#include "data/values/array.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <type_traits>
#include <typeinfo>
#include <vector>

#include "base/parallel.h"
#include "support/simd_levels.h"

namespace isostrata {
namespace {

template <class T>
PointArray array_of(const std::vector<T>& values) {
  PointArray array;
  array.name = "a";
  array.values = std::span<const T>(values);
  measure_range(array);
  return array;
}

TEST(PointArray, RangeIsThatOfTheFiniteValuesOnly) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> values{nan, 3, -infinity, -2, infinity, 7};
  const PointArray array = array_of(values);
  EXPECT_EQ(array.lower, -2);
  EXPECT_EQ(array.upper, 7);
  EXPECT_EQ(array.nan_count, 3);
}

TEST(PointArray, WithoutFiniteValuesHasLowerAboveUpper) {
  const std::vector<float> values(10, std::nanf(""));
  EXPECT_GT(array_of(values).lower, array_of(values).upper);
  EXPECT_GT(array_of(std::vector<float>{}).lower, array_of(std::vector<float>{}).upper);
}

TEST(PointArray, RangeOfEveryTypeReachesItsLimits) {
  const auto check = [](auto one) {
    using T = decltype(one);
    const std::vector<T> values{std::numeric_limits<T>::max(), T{0}, std::numeric_limits<T>::lowest()};
    const PointArray array = array_of(values);
    EXPECT_EQ(array.lower, static_cast<double>(std::numeric_limits<T>::lowest()));
    EXPECT_EQ(array.upper, static_cast<double>(std::numeric_limits<T>::max()));
  };
  check(std::int8_t{}), check(std::uint8_t{}), check(std::int16_t{}), check(std::uint16_t{}), check(std::int32_t{});
  check(std::uint32_t{}), check(std::int64_t{}), check(std::uint64_t{}), check(float{}), check(double{});
}

TEST(PointArray, RangeOfMillionsAgreesWithASerialPass) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::normal_distribution<float> normal;
  std::vector<float> values(1'500'000);
  for (float& value : values) value = normal(random);
  const auto [lower, upper] = std::minmax_element(values.begin(), values.end());
  const PointArray array = array_of(values);
  EXPECT_EQ(array.lower, *lower) << "seed " << kSeed;
  EXPECT_EQ(array.upper, *upper) << "seed " << kSeed;
}

/// Value by value, as one would write it down.
template <class T>
void expect_range_of(const std::vector<T>& values, const std::string& which) {
  double lower = std::numeric_limits<double>::infinity(), upper = -lower;
  std::int64_t not_finite = 0;
  for (const T value : values) {
    const auto v = static_cast<double>(value);
    if (!std::isfinite(v)) {
      ++not_finite;
      continue;
    }
    lower = std::min(lower, v);
    upper = std::max(upper, v);
  }
  const PointArray array = array_of(values);
  EXPECT_EQ(array.lower, lower) << which;
  EXPECT_EQ(array.upper, upper) << which;
  EXPECT_EQ(array.nan_count, not_finite) << which;
}

TEST(PointArray, RangeInVectorsIsThatOfValueByValueForEveryTypeAndLength) {
  testing::with_each_simd_level([](const std::string&) {
    const auto check = [](auto one, unsigned seed) {
      using T = decltype(one);
      std::mt19937_64 random(seed);
      for (std::size_t count = 0; count < 300; count += count < 140 ? 1 : 37) {
        std::vector<T> values(count);
        for (T& value : values) {
          value = static_cast<T>(static_cast<std::int64_t>(random()) >> (random() % 64));
          if (!std::is_floating_point_v<T> || random() % 5) continue;
          const double odd[] = {std::nan(""), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), -0.0};
          value = static_cast<T>(odd[random() % 4]);
        }
        expect_range_of(values, std::string(typeid(T).name()) + ", " + std::to_string(count) + " values, seed " + std::to_string(seed));
      }
    };
    check(std::int8_t{}, 1), check(std::uint8_t{}, 2), check(std::int16_t{}, 3), check(std::uint16_t{}, 4), check(std::int32_t{}, 5);
    check(std::uint32_t{}, 6), check(std::int64_t{}, 7), check(std::uint64_t{}, 8), check(float{}, 9), check(double{}, 10);
  });
}

TEST(ScalarSpan, RefusesBytesThatAreNoWholeNumberOfValues) {
  alignas(8) std::byte bytes[12] = {};
  EXPECT_NO_THROW(scalar_span(ScalarType::float32, std::span<const std::byte>(bytes, 12)));
  EXPECT_THROW(scalar_span(ScalarType::float64, std::span<const std::byte>(bytes, 12)), Error);
  EXPECT_THROW(scalar_span(ScalarType::float32, std::span<const std::byte>(bytes + 1, 8)), Error);
}

}  // namespace
}  // namespace isostrata
