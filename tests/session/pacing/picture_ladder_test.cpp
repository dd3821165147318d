#include "session/pacing/picture_ladder.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

using std::chrono::milliseconds;

class Ladder : public ::testing::Test {
 protected:
  /// As acknowledgements come, every 40 ms for so long. Frames cost what a simple picture does.
  void run(double bytes_per_second, Duration time, Duration queue_delay = {}) {
    for (const TimePoint end = now_ + time; now_ < end; now_ += milliseconds(40)) {
      ladder_.made(ladder_.step(), bytes());
      ladder_.link(bytes_per_second, queue_delay, 1280 * 720, now_);
    }
  }
  std::size_t bytes() const {
    const PictureStep& step = ladder_.picture();
    return static_cast<std::size_t>(40000 * step.scale * step.scale * (0.1 + 0.9 * step.quality / 90.0));
  }

  PictureLadder ladder_;
  TimePoint now_ = TimePoint{} + std::chrono::hours(1);
};

TEST_F(Ladder, GivesUpQualityThenResolutionThenRate) {
  for (int i = 1; i < PictureLadder::steps(); ++i) {
    const PictureStep& better = PictureLadder::at(i - 1);
    const PictureStep& worse = PictureLadder::at(i);
    EXPECT_LE(worse.quality, better.quality);
    EXPECT_LE(worse.scale, better.scale);
    EXPECT_GE(worse.interval_ms, better.interval_ms);
    if (worse.scale < better.scale) {
      EXPECT_LE(worse.quality, 50) << "pixels are given up only when quality has been";
    }
    EXPECT_LT(ladder_.expected_bytes(i), ladder_.expected_bytes(i - 1) + 1);
  }
}

TEST_F(Ladder, StandsWhereTheLinkCarriesIt) {
  run(1e9, milliseconds(500));
  EXPECT_EQ(ladder_.step(), 0);
  run(200e3, milliseconds(500));
  EXPECT_GT(ladder_.step(), 2);
  EXPECT_LE(static_cast<double>(bytes()), 200e3 * ladder_.picture().interval_ms / 1000.0);
  run(1, milliseconds(100));
  EXPECT_EQ(ladder_.step(), PictureLadder::steps() - 1);
}

TEST_F(Ladder, GoesDownAtOnceAndUpOnlyAfterAWhile) {
  run(1e9, milliseconds(500));
  run(200e3, milliseconds(40));
  const int low = ladder_.step();
  EXPECT_GT(low, 0);
  run(200e3, milliseconds(2000));
  run(1e9, milliseconds(400));
  EXPECT_GE(ladder_.step(), 1);
  run(1e9, milliseconds(600));
  EXPECT_EQ(ladder_.step(), 0);
}

TEST_F(Ladder, ALinkThatWaversAboutAStepDoesNotMoveIt) {
  run(400e3, milliseconds(3000));
  const int step = ladder_.step();
  for (int i = 0; i < 20; ++i) {
    run(410e3, milliseconds(160));
    run(392e3, milliseconds(160));
    EXPECT_EQ(ladder_.step(), step);
  }
}

TEST_F(Ladder, UsesLessOfALinkWhoseFramesWait) {
  run(1e6, milliseconds(3000));
  const double full = ladder_.usable_bytes_per_second();
  EXPECT_GT(full, 0.8e6);
  EXPECT_LE(full, 1e6);
  run(1e6, milliseconds(1000), milliseconds(80));
  EXPECT_LT(ladder_.usable_bytes_per_second(), 0.6 * full);
  const double low = ladder_.usable_bytes_per_second();
  run(1e6, milliseconds(1000), milliseconds(30));
  EXPECT_EQ(ladder_.usable_bytes_per_second(), low) << "neither too much nor too little";
  run(1e6, milliseconds(3000), milliseconds(5));
  EXPECT_NEAR(ladder_.usable_bytes_per_second(), full, 1);
}

TEST_F(Ladder, VideoIsToldItsRateAndGivesUpPixelsOnlyWhereTheyWouldBeStarved) {
  ladder_.set_video(true);
  EXPECT_GT(ladder_.bitrate_kbps(), 0) << "something to begin with";
  run(250e3, milliseconds(3000));
  EXPECT_EQ(ladder_.picture().scale, 1) << "2 Mb/s are enough for a video of 1280x720";
  const double frame_bits = ladder_.bitrate_kbps() * 1000.0 / 30;
  EXPECT_LE(frame_bits, 8 * 250e3 * ladder_.picture().interval_ms / 1000);
  run(30e3, milliseconds(1000));
  EXPECT_LT(ladder_.picture().scale, 1);
  run(1e9, milliseconds(2000));
  EXPECT_EQ(ladder_.step(), 0);
  EXPECT_LT(ladder_.bitrate_kbps(), 20000);
}

}  // namespace
}  // namespace isostrata
