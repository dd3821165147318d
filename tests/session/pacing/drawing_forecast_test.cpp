// Laws of telling what the first picture of a gesture takes, on a ticked clock.
#include "session/pacing/drawing_forecast.h"

#include <gtest/gtest.h>

#include <random>

namespace isostrata {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr double kWhole = 0.9216;  // megapixels of 1280x720

class Forecast : public ::testing::Test {
 protected:
  void move(double ms, double pixels, int times) {
    for (int i = 0; i < times; ++i) forecast_.moved(Codec::jpeg, ms, pixels, now_ += milliseconds(20));
  }
  double ms(double pixels) const { return forecast_.ms(Codec::jpeg, pixels, now_); }

  DrawingForecast forecast_;
  TimePoint now_ = TimePoint{} + std::chrono::hours(1);
};

TEST_F(Forecast, NothingIsForecastBeforeAPictureWasDrawn) { EXPECT_EQ(ms(kWhole), 0); }

TEST_F(Forecast, ThePictureAtRestTellsTheFirstOneOfAGesture) {
  forecast_.rested(100, kWhole, now_);
  EXPECT_DOUBLE_EQ(ms(kWhole), DrawingForecast::kBeside * 100);
  double last = ms(kWhole);
  for (double pixels = 0.8; pixels > 0.05; pixels -= 0.1) {
    EXPECT_LT(ms(pixels), last);
    EXPECT_GT(ms(pixels), last / 2) << "no picture costs its pixels alone";
    last = ms(pixels);
  }
}

TEST_F(Forecast, ARestShowsWhatTheNextGestureBeginsWithWhateverMovedBefore) {
  forecast_.rested(10, kWhole, now_);
  move(12, kWhole, 100);
  now_ += seconds(5);
  forecast_.rested(200, kWhole, now_);
  EXPECT_DOUBLE_EQ(ms(kWhole), DrawingForecast::kBeside * 200);
}

TEST_F(Forecast, WhatMovesTakesThePlaceOfWhatRested) {
  forecast_.rested(20, kWhole, now_);
  double last = ms(kWhole);
  for (int i = 0; i < 10; ++i) {
    move(80, kWhole, 1);
    EXPECT_GT(ms(kWhole), last);
    last = ms(kWhole);
  }
  move(80, kWhole, 200);
  EXPECT_NEAR(ms(kWhole), 80, 2);
}

TEST_F(Forecast, OfTimesThatGrowWithPixelsBothSizesAreToldOnceBothWereSeen) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1), whole(20, 300);
  for (int world = 0; world < 200; ++world) {
    const double share = part(random), all = whole(random), small = 0.3 * kWhole;
    const auto drawing = [&](double pixels) { return all * (1 - share + share * pixels / kWhole); };
    now_ += seconds(600);
    forecast_.rested(drawing(kWhole) / DrawingForecast::kBeside, kWhole, now_);
    move(drawing(small), small, 8);
    EXPECT_NEAR(ms(small), drawing(small), 0.01 * drawing(small)) << "world " << world << " of seed 5";
    EXPECT_NEAR(ms(kWhole), drawing(kWhole), 0.01 * all) << "world " << world << " of seed 5";
  }
}

}  // namespace
}  // namespace isostrata
