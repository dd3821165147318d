// Keys hold the order of values and the rule of equality, exactly. Nothing here needs OpenGL.
#include "rendering/device/field_keys.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "extraction/small_grids.h"
#include "rendering/gl/layout.h"
#include "tables/interval_table.h"

namespace isostrata {
namespace {

std::uint64_t joined(std::uint32_t high, std::uint32_t low, const KeyFormat& format) {
  return format.bytes == 8 ? std::uint64_t{high} << 32 | low : high;
}

/// The class of a value as the shaders compute it.
int class_by_keys(const KeyFormat& format, const shaders::IsoKeys& rule, double value) {
  const std::uint64_t key = key_of(format, value);
  return static_cast<int>(key >= joined(rule.lower_high, rule.lower_low, format)) +
         static_cast<int>(key > joined(rule.last_high, rule.last_low, format));
}

/// Values of the type that are likely to tell rules apart, promoted.
template <class T>
std::vector<double> telling_values(std::mt19937_64& random) {
  using Limits = std::numeric_limits<T>;
  std::vector<double> values{static_cast<double>(Limits::lowest()), static_cast<double>(Limits::max()), 0.0, 1.0, 2.0};
  if constexpr (std::is_floating_point_v<T>) {
    for (const double v : {-0.0, -1.0, 0.1, 1e-30, -1e-30, static_cast<double>(Limits::denorm_min()),
                           static_cast<double>(Limits::min()), static_cast<double>(static_cast<T>(0.1))})
      values.push_back(static_cast<double>(static_cast<T>(v)));
    std::normal_distribution<double> normal(0, 3);
    for (int i = 0; i < 40; ++i) values.push_back(static_cast<double>(static_cast<T>(normal(random))));
  } else {
    std::uniform_int_distribution<std::int64_t> uniform(
        std::max<std::int64_t>(Limits::lowest(), -(1ll << 62)),
        static_cast<std::int64_t>(std::min<std::uint64_t>(Limits::max(), 1ull << 62)));
    for (int i = 0; i < 40; ++i) values.push_back(static_cast<double>(static_cast<T>(uniform(random))));
    if (std::is_signed_v<T>) values.push_back(-1.0);
  }
  return values;
}

template <class T>
void expect_order_and_classes(ScalarType type) {
  const KeyFormat format = key_format(type);
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    std::mt19937_64 random(seed);
    const std::vector<double> values = telling_values<T>(random);
    for (const double a : values)
      for (const double b : values)
        ASSERT_EQ(key_of(format, a) < key_of(format, b), a < b) << to_string(type) << " " << a << " " << b;

    // Ends at values, beside them and between them.
    std::vector<double> ends;
    for (const double v : values) {
      ends.push_back(v);
      ends.push_back(std::nextafter(v, 1e308));
      ends.push_back(v + 0.5);
    }
    for (const double far : {-1e300, 1e300, -1e10, 1e10, 256.0, -129.0}) ends.push_back(far);
    std::shuffle(ends.begin(), ends.end(), random);
    std::vector<Interval> intervals;
    for (std::size_t i = 0; i + 1 < 12; ++i)
      if (ends[i] < ends[i + 1]) intervals.push_back({ends[i], ends[i + 1]});
    if (intervals.empty()) continue;
    const IsoRules rules(intervals);
    const KeyedRules keyed = keyed_rules(format, rules);
    std::vector<bool> there(intervals.size());
    double before = -std::numeric_limits<double>::infinity();
    for (const shaders::IsoKeys& rule : keyed.rules) {
      there[rule.interval] = true;
      EXPECT_LE(before, intervals[rule.interval].lower);
      before = intervals[rule.interval].lower;
      for (const double v : values)
        ASSERT_EQ(class_by_keys(format, rule, v), rules.rules()[rule.interval].class_of(v))
            << to_string(type) << ", seed " << seed << ", value " << v << ", interval " << intervals[rule.interval].lower << ":"
            << intervals[rule.interval].upper;
    }
    for (std::size_t i = 0; i < intervals.size(); ++i) {  // what was left out can be active nowhere
      if (there[i]) continue;
      const int first = rules.rules()[i].class_of(values.front());
      EXPECT_NE(first, 1);
      for (const double v : values) EXPECT_EQ(rules.rules()[i].class_of(v), first) << to_string(type) << ", seed " << seed;
    }
    // An edge crosses an isovalue where its ends are on two sides of it.
    for (const IsoRule& rule : rules.rules())
      for (const auto& [index, bound] : {std::pair{rule.lower_index, rule.lower}, std::pair{rule.upper_index, rule.above}}) {
        const shaders::IsoLevel& level = keyed.levels[index];
        const std::uint64_t below = joined(level.below_high, level.below_low, format);
        for (const double a : values)
          for (const double b : values)
            ASSERT_EQ((key_of(format, a) > below) != (key_of(format, b) > below), (a >= bound) != (b >= bound))
                << to_string(type) << ", seed " << seed << ", " << a << " " << b << " " << bound;
      }
  }
}

TEST(FieldKeys, KeepTheOrderAndTheClassesOfIntegers) {
  expect_order_and_classes<std::int8_t>(ScalarType::int8);
  expect_order_and_classes<std::uint8_t>(ScalarType::uint8);
  expect_order_and_classes<std::int16_t>(ScalarType::int16);
  expect_order_and_classes<std::uint16_t>(ScalarType::uint16);
  expect_order_and_classes<std::int32_t>(ScalarType::int32);
  expect_order_and_classes<std::uint32_t>(ScalarType::uint32);
}

TEST(FieldKeys, KeepTheOrderAndTheClassesOfFloats) {
  expect_order_and_classes<float>(ScalarType::float32);
  expect_order_and_classes<double>(ScalarType::float64);
}

TEST(FieldKeys, PromoteIntegersOf64BitsAsTheCpuDoes) {
  expect_order_and_classes<std::int64_t>(ScalarType::int64);
  expect_order_and_classes<std::uint64_t>(ScalarType::uint64);
}

// The device numbers points without looking at cells: a point of a cell is in use if it is inside, or where the ends of its
// edge are on two sides of an isovalue. The table must say the same for every case.
TEST(FieldKeys, ACaseUsesJustTheVerticesInsideAndTheEdgesThatCross) {
  const HexahedronTable& table = hexahedron_table();
  const CellTopology& cell = topology(CellType::hexahedron);
  ASSERT_EQ(table.isovertices.size(), static_cast<std::size_t>(HEXAHEDRON_CASES));
  for (int i = 0; i < HEXAHEDRON_CASES; ++i) {
    std::array<int, 8> classes{};
    for (int v = 0, rest = i; v < 8; ++v, rest /= 3) classes[v] = rest % 3;
    const auto [lowest, highest] = std::minmax_element(classes.begin(), classes.end());
    std::uint32_t expected = 0;
    if (*highest > 0 && *lowest < 2) {
      for (int v = 0; v < 8; ++v) expected |= static_cast<std::uint32_t>(classes[v] == 1) << v;
      for (int e = 0; e < 12; ++e)
        for (int side = 1; side <= 2; ++side)
          if ((classes[cell.edges[e][0]] >= side) != (classes[cell.edges[e][1]] >= side))
            expected |= 1u << (8 + 12 * (side - 1) + e);
    }
    ASSERT_EQ(table.isovertices[i], expected) << "case " << i;
    EXPECT_LT(table.of(i).size(), 1u << CASE_COUNT_BITS);
  }
  EXPECT_LT(table.tetrahedra.size(), 1u << (32 - CASE_COUNT_BITS));
  EXPECT_LE(HEXAHEDRON_CASES - 1u, RECORD_CASE_MASK);
}

}  // namespace
}  // namespace isostrata
