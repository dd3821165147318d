#include "session/pacing/making_costs.h"

#include <gtest/gtest.h>

#include "engine/messages/coarse_levels.h"

namespace isostrata {
namespace {

class MakingCostsOfASession : public ::testing::Test {
 protected:
  struct Times {
    double extract = 0, draw = 0, encode = 0;
  };
  static FrameReady ready(Times times, int stride = 1) {
    FrameReady of;
    of.width = of.height = 1000;
    of.stages.extract_ms = times.extract;
    of.stages.draw_ms = times.draw;
    of.stages.encode_ms = times.encode;
    of.point_stride = stride;
    of.coarse_at_hand = true;
    return of;
  }
  void rest(Times times) {
    FrameRequest request;
    request.lossless = true;
    costs_.made(request, FramePhase::lossless, ready(times), now_ += std::chrono::seconds(2));
  }
  void move(Times times, int level = 0) {
    FrameRequest request;
    request.coarse = level;
    costs_.made(request, FramePhase::moving, ready(times, level > 0 ? 2 : 1), now_ += std::chrono::milliseconds(30));
  }

  MakingCosts costs_;
  TimePoint now_{std::chrono::hours(1)};
};

TEST_F(MakingCostsOfASession, BeginWithThePictureThatRests) {
  EXPECT_EQ(costs_.drawing_ms(0, Codec::jpeg, 1, now_), 0);
  EXPECT_EQ(costs_.extraction_ms(0, 0), 0);
  rest({.extract = 400, .draw = 100});
  EXPECT_NEAR(costs_.drawing_ms(0, Codec::jpeg, 1, now_), 100 * DrawingForecast::kBeside, 1e-6);
  EXPECT_LT(costs_.drawing_ms(0, Codec::jpeg, 0.25, now_), costs_.drawing_ms(0, Codec::jpeg, 1, now_));
  EXPECT_EQ(costs_.extraction_ms(0, 0), 400);
  for (int level = 1; level <= kCoarseLevels; ++level) {
    EXPECT_LT(costs_.drawing_ms(level, Codec::jpeg, 1, now_), costs_.drawing_ms(level - 1, Codec::jpeg, 1, now_)) << level;
    EXPECT_LT(costs_.extraction_ms(level, 10), costs_.extraction_ms(level - 1, 10)) << level;
  }
  EXPECT_EQ(costs_.encoding_ms(Codec::jpeg, now_), 0) << "a lossless picture tells nothing of it";
}

TEST_F(MakingCostsOfASession, OfEveryNthPointAreThoseThatWereMeasuredWhateverTheLevel) {
  rest({.extract = 800, .draw = 100});
  const double guessed = costs_.extraction_ms(1, 0);
  move({.extract = 10, .draw = 20}, 3);
  EXPECT_NEAR(costs_.extraction_ms(3, 20), 10, 1e-9);
  EXPECT_NEAR(costs_.extraction_ms(3, 0), 5, 1e-9) << "a drawing beside it takes half of the machine as long as both last";
  EXPECT_NEAR(costs_.extraction_ms(3, 2), 7, 1e-9);
  EXPECT_NEAR(costs_.extraction_ms(1, 0), 40, 1e-9) << "half the points along each axis: an eighth of the cells";
  EXPECT_NE(costs_.extraction_ms(1, 0), guessed);
  EXPECT_EQ(costs_.extraction_ms(0, 0), 800);
  move({.extract = 50, .draw = 20}, 3);
  EXPECT_NEAR(costs_.extraction_ms(3, 20), 50, 1e-9);
  EXPECT_NEAR(costs_.extraction_ms(3, 10), 40, 1e-9);
}

TEST_F(MakingCostsOfASession, OfEveryNthPointThereAreSomeForWhoMovesLayersBeforeHeDoes) {
  FrameReady at_rest = ready({.extract = 400, .draw = 100});
  at_rest.coarse_at_hand = false;
  at_rest.layers_may_be_coarse = true;
  FrameRequest request;
  request.lossless = true;
  costs_.made(request, FramePhase::lossless, at_rest, now_);
  EXPECT_FALSE(costs_.coarse_at_hand()) << "for who turns";
  costs_.note_moved_layers();
  EXPECT_TRUE(costs_.coarse_at_hand());
}

TEST_F(MakingCostsOfASession, AHandMovesLayersUntilItRests) {
  EXPECT_FALSE(costs_.moves_layers());
  costs_.note_moved_layers();
  move({.draw = 20, .encode = 5});
  EXPECT_TRUE(costs_.moves_layers());
  rest({.draw = 20});
  EXPECT_FALSE(costs_.moves_layers());
}

TEST_F(MakingCostsOfASession, PicturesToKeepAndThoseOfMoreSamplesTellNothing) {
  rest({.draw = 100});
  const double before = costs_.drawing_ms(0, Codec::jpeg, 1, now_);
  FrameRequest still;
  still.still = StillFormat::png;
  FrameRequest refined;
  refined.lossless = true;
  refined.samples = 4;
  for (const FrameRequest& request : {still, refined}) costs_.made(request, FramePhase::lossless, ready({.draw = 9000}), now_);
  EXPECT_EQ(costs_.drawing_ms(0, Codec::jpeg, 1, now_), before);
}

TEST_F(MakingCostsOfASession, AKeyFrameTellsNothingOfEncoding) {
  FrameReady key = ready({.draw = 10, .encode = 5000});
  key.video = VideoFacts{.key = true};
  for (int i = 0; i < 20; ++i) costs_.made({}, FramePhase::moving, key, now_ += std::chrono::milliseconds(30));
  EXPECT_EQ(costs_.encoding_ms(Codec::jpeg, now_), 0);
  for (int i = 0; i < 20; ++i) move({.draw = 10, .encode = 5});
  EXPECT_NEAR(costs_.encoding_ms(Codec::jpeg, now_), 5 / coding_weight(1), 0.5);
}

TEST_F(MakingCostsOfASession, WhatIsQuicklyDrawnMayHaveMoreSamples) {
  rest({.draw = 10});
  EXPECT_EQ(costs_.most_samples(), FrameScheduler::kMostSamples);
  rest({.draw = 200});
  EXPECT_EQ(costs_.most_samples(), 2) << "16 times as long is more than 2 s";
  rest({.draw = 1000});
  EXPECT_EQ(costs_.most_samples(), 1);
}

}  // namespace
}  // namespace isostrata
