#include "data/derived/series_ranges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "data/array_of.h"

namespace isostrata {
namespace {

struct Series {
  std::vector<std::vector<std::vector<double>>> values;  // [nt][arrays][np]

  Dataset at(int step) const {
    Dataset dataset;
    dataset.step = step;
    dataset.times.clear();
    for (std::size_t t = 0; t < values.size(); ++t) dataset.times.push_back(static_cast<double>(t));
    for (std::size_t a = 0; a < values[static_cast<std::size_t>(step)].size(); ++a) {
      PointArray array = array_of(values[static_cast<std::size_t>(step)][a]);
      array.name = "f" + std::to_string(a);
      dataset.arrays.push_back(array);
    }
    return dataset;
  }
};

TEST(SeriesRanges, AreThoseOfAllValuesWhateverTheOrderOfTheSteps) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> value;
    Series series;
    std::vector<double> all;
    for (int t = 0; t < 9; ++t) {
      std::vector<double> values(5);
      for (double& v : values) v = t == 0 ? 0 : t * value(random);  // constant at step 0
      all.insert(all.end(), values.begin(), values.end());
      series.values.push_back({values});
    }
    std::vector<int> order{0, 1, 2, 3, 4, 5, 6, 7, 8};
    std::shuffle(order.begin(), order.end(), random);
    SeriesRanges ranges(series.at(order[0]));
    for (int i = 1; i < 9; ++i) {
      EXPECT_FALSE(ranges.complete());
      EXPECT_NE(std::find(order.begin() + i, order.end(), ranges.next()), order.end());
      ranges.add(series.at(order[static_cast<std::size_t>(i)]));
      ranges.add(series.at(order[0]));  // each counts once
      EXPECT_EQ(ranges.known_steps(), i + 1);
    }
    EXPECT_TRUE(ranges.complete());
    EXPECT_EQ(ranges.next(), -1);
    const ArrayRanges& of = ranges.arrays().front();
    const auto [least, most] = std::minmax_element(all.begin(), all.end());
    EXPECT_EQ(of.all, (ValueRange{*least, *most}));
    EXPECT_EQ(of.steps[0], (ValueRange{0, 0}));
    double widest = 0;
    for (int t = 0; t < 9; ++t) {
      const auto& step = of.steps[static_cast<std::size_t>(t)];
      EXPECT_EQ(step, (ValueRange{series.at(t).arrays[0].lower, series.at(t).arrays[0].upper}));
      widest = std::max(widest, step.upper - step.lower);
    }
    const ValueRange& chosen = of.steps[static_cast<std::size_t>(ranges.widest_step("f0"))];
    EXPECT_EQ(chosen.upper - chosen.lower, widest);
  }
}

TEST(SeriesRanges, LeaveOutWhatHasNoValueAndWhatCannotBeRead) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Series series{{{{nan, nan}, {1, 2}}, {{3, nan}}, {{9, 9}, {9, 9}}}};
  SeriesRanges ranges(series.at(0));
  EXPECT_TRUE(ranges.arrays()[0].all.empty());
  ranges.add(series.at(1));  // has no second array
  ranges.skip(2);
  EXPECT_TRUE(ranges.complete());
  EXPECT_EQ(ranges.arrays()[0].all, (ValueRange{3, 3}));
  EXPECT_EQ(ranges.arrays()[0].nan_count, 2);
  EXPECT_TRUE(ranges.arrays()[0].steps[0].empty());
  EXPECT_TRUE(ranges.arrays()[0].steps[2].empty());
  EXPECT_EQ(ranges.arrays()[1].all, (ValueRange{1, 2}));
  EXPECT_TRUE(ranges.arrays()[1].steps[1].empty());
}

TEST(SeriesRanges, HaveTheBoxOfAllStepsAndAWordWhereTheyDiffer) {
  const Series series{{{{1}}, {{2}}, {{3}}}};
  const auto in_box = [&](int step, Vec3d lower, Vec3d upper) {
    Dataset dataset = series.at(step);
    dataset.bounds = {lower, upper};
    return dataset;
  };
  SeriesRanges ranges(in_box(0, {0, 0, 0}, {10, 10, 1}));
  ranges.add(in_box(1, {0, 0, 0}, {10, 9.9, 1}));  // every n-th point of it
  EXPECT_FALSE(ranges.note_of_boxes());
  ranges.add(in_box(2, {5, -2, 0}, {15, 10, 1}));
  EXPECT_EQ(ranges.bounds().lower, (Vec3d{0, -2, 0}));
  EXPECT_EQ(ranges.bounds().upper, (Vec3d{15, 10, 1}));
  EXPECT_EQ(ranges.note_of_boxes(), "steps lie in boxes of their own; all that were read in x [0, 15] y [-2, 10] z [0, 1]");
}

TEST(SeriesRanges, OfALongSeriesKeepNoListPerStep) {
  Dataset dataset;
  dataset.times.resize(SeriesRanges::kMostKept + 1);
  const std::vector<float> first{1, 2}, last{-5, 7};
  dataset.arrays = {array_of(first)};
  SeriesRanges ranges(dataset);
  dataset.step = static_cast<int>(SeriesRanges::kMostKept);
  dataset.arrays = {array_of(last)};
  ranges.add(dataset);
  EXPECT_EQ(ranges.arrays()[0].all, (ValueRange{-5, 7}));
  EXPECT_EQ(ranges.arrays()[0].steps, (std::vector<ValueRange>{{1, 2}}));
}

}  // namespace
}  // namespace isostrata
