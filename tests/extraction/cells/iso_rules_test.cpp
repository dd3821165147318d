#include "extraction/cells/iso_rules.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <random>
#include <set>

namespace isostrata {
namespace {

TEST(IsoRules, AnEndIsClosedUnlessAnIntervalBeginsThere) {
  const std::vector<Interval> intervals{{0, 1}, {1, 2}, {0.5, 1}, {3, 4}};
  const IsoRules rules(intervals);
  EXPECT_EQ(rules.rules()[0].class_of(0), 1);
  EXPECT_EQ(rules.rules()[0].class_of(1), 2);
  EXPECT_EQ(rules.rules()[1].class_of(1), 1);
  EXPECT_EQ(rules.rules()[1].class_of(2), 1);
  EXPECT_EQ(rules.rules()[2].class_of(1), 2);
  EXPECT_EQ(rules.rules()[3].class_of(4), 1);
  EXPECT_EQ(rules.rules()[3].class_of(std::nextafter(4, 5)), 2);
  EXPECT_EQ(rules.rules()[3].class_of(std::nextafter(3, 2)), 0);
}

TEST(IsoRules, IsovaluesAreDistinctAndShared) {
  const std::vector<Interval> intervals{{1, 2}, {0, 1}, {1, 3}};
  const IsoRules rules(intervals);
  EXPECT_EQ(std::vector<double>(rules.isovalues().begin(), rules.isovalues().end()), (std::vector<double>{0, 1, 2, 3}));
  EXPECT_EQ(rules.rules()[0].lower_index, rules.rules()[1].upper_index);
}

TEST(IsoRules, VisitsExactlyTheIntervalsThatACellIsActiveIn) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<int> whole(0, 20);
    std::vector<Interval> intervals;
    for (std::uint64_t i = 0; i < seed; ++i) {
      const int lower = whole(random);
      intervals.push_back({double(lower), lower + 1 + whole(random) / 4.0});
    }
    const IsoRules rules(intervals);
    for (int trial = 0; trial < 200; ++trial) {
      const double a = whole(random), b = whole(random) + 0.5 * (trial % 2), minimum = std::min(a, b), maximum = std::max(a, b);
      std::set<int> expected, visited;
      for (std::size_t i = 0; i < intervals.size(); ++i) {
        const IsoRule& rule = rules.rules()[i];
        if (rule.class_of(maximum) > 0 && rule.class_of(minimum) < 2) expected.insert(static_cast<int>(i));
      }
      rules.visit_active(minimum, maximum, [&](std::uint16_t i, const IsoRule&) { EXPECT_TRUE(visited.insert(i).second); });
      ASSERT_EQ(visited, expected) << "seed " << seed << ", values " << minimum << " to " << maximum;
    }
  }
}

TEST(IsoRules, TheComplementHoldsJustWhatIsInNoInterval) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<int> whole(0, 20);
    std::vector<Interval> intervals;
    for (std::uint64_t i = 0; i < 1 + seed % 5; ++i) {
      const int lower = whole(random);
      intervals.push_back({double(lower), lower + 1 + whole(random) / 4.0});
    }
    const IsoRules plain(intervals), rules(intervals, true);
    std::vector<double> ends(plain.isovalues().begin(), plain.isovalues().end());
    ends.insert(ends.begin(), std::numeric_limits<double>::lowest());
    ends.push_back(std::numeric_limits<double>::max());
    EXPECT_EQ(ends, std::vector<double>(rules.isovalues().begin(), rules.isovalues().end()));
    std::map<std::uint32_t, double> thresholds;  // one for each isosurface: what ends there and what begins there agree
    for (const IsoRule& rule : rules.rules()) {
      EXPECT_EQ(thresholds.emplace(rule.lower_index, rule.lower).first->second, rule.lower) << "seed " << seed;
      EXPECT_EQ(thresholds.emplace(rule.upper_index, rule.above).first->second, rule.above) << "seed " << seed;
    }
    std::vector<double> values{-1e300, 1e300, -std::numeric_limits<double>::max(), std::numeric_limits<double>::max()};
    for (const double end : plain.isovalues())
      for (const double value : {std::nextafter(end, -1e9), end, std::nextafter(end, 1e9), end + 0.1}) values.push_back(value);
    for (const double value : values) {
      int in = 0, out = 0;
      for (std::size_t i = 0; i < rules.rules().size(); ++i)
        (i < intervals.size() ? in : out) += rules.rules()[i].class_of(value) == 1;
      ASSERT_EQ(out, in == 0 ? 1 : 0) << "seed " << seed << ", value " << value;
    }
  }
}

}  // namespace
}  // namespace isostrata
