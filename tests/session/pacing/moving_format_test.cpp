#include "session/pacing/moving_format.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isostrata {
namespace {

/// A session whose costs are what the test says, and one viewer with a window.
class MovingFormatOfAViewer : public ::testing::Test {
 protected:
  MovingFormatOfAViewer() { frames_.set_viewport(1000, 1000, false, now_); }

  void cost(double draw_ms, double encode_ms) {
    FrameRequest lossless;
    lossless.lossless = true;
    FrameReady ready;
    ready.width = ready.height = 1000;
    ready.stages.draw_ms = draw_ms;
    costs_.made(lossless, FramePhase::lossless, ready, now_);
    ready.stages.encode_ms = encode_ms;
    for (int i = 0; i < 20; ++i) costs_.made({}, FramePhase::moving, ready, now_ += std::chrono::milliseconds(30));
  }
  bool choose(const MovingFormat::Others& others = {}) { return format_.choose(frames_, costs_, others, now_ += std::chrono::milliseconds(50)); }
  /// The forecast of this codec at the size that was chosen; 0: there is none.
  double forecast(Codec codec) {
    for (const FormatForecast& of : format_.forecasts())
      if (of.codec == codec) return of.ms;
    return 0;
  }

  TimePoint now_{std::chrono::hours(1)};
  FrameScheduler frames_;
  MakingCosts costs_;
  MovingFormat format_;
};

TEST_F(MovingFormatOfAViewer, NothingIsChosenBeforeSomethingIsKnown) {
  EXPECT_FALSE(choose());
  EXPECT_TRUE(format_.forecasts().empty());
  EXPECT_EQ(format_.codec(), Codec::jpeg);
  EXPECT_EQ(format_.scale(), 1);
}

TEST_F(MovingFormatOfAViewer, WhoHasNoChoiceGetsTheFirstAndStepsDownFromIt) {
  format_.set_codecs({Codec::vp9_444, Codec::jpeg}, false);
  EXPECT_FALSE(format_.due(now_));
  EXPECT_EQ(format_.codec(), Codec::vp9_444);
  format_.step_down();
  EXPECT_EQ(format_.codec(), Codec::jpeg);
  format_.step_down();
  EXPECT_EQ(format_.codec(), Codec::jpeg) << "which everybody takes";
}

TEST_F(MovingFormatOfAViewer, ASlowMachineMakesSmallerPictures) {
  format_.set_codecs({Codec::jpeg}, true);
  cost(5, 2);
  choose();
  EXPECT_EQ(format_.scale(), 1);
  ASSERT_EQ(format_.forecasts().size(), 1u);
  EXPECT_EQ(format_.forecasts()[0].width, 1000);
  cost(200, 80);
  choose();
  EXPECT_LT(format_.scale(), 1);
  EXPECT_EQ(format_.forecasts()[0].width, std::lround(1000 * format_.scale()));
}

TEST_F(MovingFormatOfAViewer, APictureThatNobodyElseLooksAtIsADrawingMore) {
  format_.set_codecs({Codec::vp9_444, Codec::jpeg}, true);
  cost(8, 2);  // in time at full size, also with a drawing more
  choose();
  const double jpeg = forecast(Codec::jpeg), video = forecast(Codec::vp9_444);
  ASSERT_GT(jpeg, 0);
  ASSERT_GT(video, 0);
  choose({.all = 1, .with = {1, 0}});
  EXPECT_NEAR(forecast(Codec::jpeg), jpeg, 0.1 * jpeg);
  EXPECT_GT(forecast(Codec::vp9_444), video + 5);
  choose({.all = 1, .with = {0, 1}});
  EXPECT_GT(forecast(Codec::jpeg), jpeg + 5);
}

TEST_F(MovingFormatOfAViewer, ForecastsFollowWhatTheClientSaysOfItsDecodingIfThatCanBe) {
  format_.set_codecs({Codec::jpeg}, true);
  cost(5, 2);
  choose();
  const double before = forecast(Codec::jpeg);
  std::uint64_t frame = 0;
  const auto decode = [&](double ms) {
    for (int i = 0; i < 20; ++i) {
      format_.sent({}, ++frame, 1);
      format_.decoded(frame, ms, now_ += std::chrono::milliseconds(30));
    }
    choose();
  };
  for (const double nonsense : {-1.0, 0.0, std::nan(""), 1e9}) decode(nonsense);
  EXPECT_NEAR(forecast(Codec::jpeg), before, 0.5);
  format_.decoded(4711, 900, now_);
  decode(25);
  EXPECT_GT(forecast(Codec::jpeg), before + 10);
}

TEST_F(MovingFormatOfAViewer, TheFirstFrameOfAStreamTellsNothingOfDecoding) {
  format_.set_codecs({Codec::jpeg}, true);
  cost(5, 2);
  choose();
  const double before = forecast(Codec::jpeg);
  FrameOrder key;
  key.key = true;
  for (std::uint64_t frame = 1; frame < 20; ++frame) {
    format_.sent(key, frame, 1);
    format_.decoded(frame, 500, now_ += std::chrono::milliseconds(30));
  }
  choose();
  EXPECT_NEAR(forecast(Codec::jpeg), before, 0.5);
}

TEST_F(MovingFormatOfAViewer, AChoiceIsDueAfterAPauseOrWhenAGestureBegins) {
  format_.set_codecs({Codec::jpeg}, true);
  EXPECT_TRUE(format_.due(now_));
  choose();
  EXPECT_FALSE(format_.due(now_ + MovingFormat::kChoose / 2));
  EXPECT_TRUE(format_.due(now_ + MovingFormat::kChoose));
  format_.hurry();
  EXPECT_TRUE(format_.due(now_));
}

}  // namespace
}  // namespace isostrata
