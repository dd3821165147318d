#include "session/pacing/frame_scheduler.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace isostrata {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A viewer on a ticked clock whose engine answers at once.
class Scheduler : public ::testing::Test {
 protected:
  Scheduler() {
    frames_.set_viewport(640, 480, false, now_);
    change();
  }
  void tick(Duration time) { now_ += time; }
  void change() { frames_.scene_changed(++revision_, true, now_); }
  std::uint64_t deliver(const FrameOrder& order) {
    frames_.started(revision_);
    return frames_.sent(order, revision_, kBytes, now_);
  }
  void deliver_and_acknowledge(const FrameOrder& order) { frames_.acknowledged(deliver(order), now_); }
  /// Frames of kBytes take so long to pass: the scheduler has seen many.
  void learn_link(Duration passing) {
    for (int i = 0; i < 12; ++i) {
      change();
      const auto order = frames_.next(now_);
      ASSERT_TRUE(order);
      const auto id = deliver(*order);
      tick(passing);
      frames_.acknowledged(id, now_);
    }
  }

  static constexpr std::size_t kBytes = 20000;
  FrameScheduler frames_;
  TimePoint now_ = TimePoint{} + std::chrono::hours(1);
  std::uint64_t revision_ = 0;
};

TEST_F(Scheduler, AFloodGetsNoMoreFramesThanAHandAndTheLastChangeIsShown) {
  int frames = 0;
  std::uint64_t shown = 0;
  for (int i = 0; i < 10000; ++i) {
    tick(std::chrono::microseconds(100));
    change();
    if (const auto order = frames_.next(now_)) {
      ++frames;
      shown = revision_;
      deliver_and_acknowledge(*order);
    }
  }
  EXPECT_LE(frames, static_cast<int>(FrameScheduler::kMostFps + FrameScheduler::kBurst) + 1);
  EXPECT_GE(frames, static_cast<int>(FrameScheduler::kMostFps) - 1);
  for (int i = 0; shown < revision_ && i < 3; ++i) {
    const auto wake = frames_.wake_at(now_);
    ASSERT_TRUE(wake);
    now_ = *wake;
    if (frames_.next(now_)) shown = revision_;
  }
  EXPECT_EQ(shown, revision_);
}

TEST_F(Scheduler, AChangeGivesAMovingFrameAndRestALosslessOneOfTheSameState) {
  auto order = frames_.next(now_);
  ASSERT_TRUE(order);
  EXPECT_FALSE(order->lossless);
  EXPECT_EQ(order->width, 640);
  deliver_and_acknowledge(*order);
  EXPECT_FALSE(frames_.next(now_));
  const auto wake = frames_.wake_at(now_);
  ASSERT_TRUE(wake);
  now_ = *wake;
  order = frames_.next(now_);
  ASSERT_TRUE(order);
  EXPECT_TRUE(order->lossless);
  deliver_and_acknowledge(*order);
  tick(seconds(10));
  EXPECT_FALSE(frames_.next(now_));
  EXPECT_FALSE(frames_.wake_at(now_));
}

TEST_F(Scheduler, RestBringsMoreSamplesIfTheyAreWantedAndASlowLineDoesNot) {
  const auto rest = [&] {
    change();
    deliver_and_acknowledge(*frames_.next(now_));
    tick(FrameScheduler::kSettle);
    deliver_and_acknowledge(*frames_.next(now_));
  };
  rest();
  EXPECT_FALSE(frames_.wake_at(now_)) << "nobody wants it";
  frames_.set_most_samples(4);
  for (const int samples : {2, 4}) {
    const auto wake = frames_.wake_at(now_);
    ASSERT_TRUE(wake) << samples;
    now_ = std::max(now_, *wake);
    EXPECT_FALSE(frames_.next(now_));
    const auto order = frames_.refined(now_);
    ASSERT_TRUE(order) << samples;
    EXPECT_EQ(order->samples, samples);
    EXPECT_TRUE(order->lossless);
    frames_.put_back();
    EXPECT_EQ(frames_.refined(now_)->samples, samples) << "what was put back is as if never given";
    deliver_and_acknowledge(*order);
  }
  EXPECT_FALSE(frames_.wake_at(now_));
  EXPECT_FALSE(frames_.refined(now_ + seconds(10)));

  rest();
  frames_.set_interaction(true, now_);
  EXPECT_FALSE(frames_.refined(now_ + seconds(10))) << "a hand holds it";
  frames_.set_interaction(false, now_);
  tick(seconds(1));
  ASSERT_TRUE(frames_.refined(now_));
  change();
  EXPECT_TRUE(frames_.withdraw_order()) << "a change comes first";
  EXPECT_FALSE(frames_.next(now_)->lossless);
}

TEST_F(Scheduler, NothingIsLosslessWhileSomeoneInteracts) {
  deliver_and_acknowledge(*frames_.next(now_));
  frames_.set_interaction(true, now_);
  change();
  deliver_and_acknowledge(*frames_.next(now_));
  tick(seconds(60));
  EXPECT_FALSE(frames_.next(now_));
  change();
  const auto order = frames_.next(now_);
  EXPECT_FALSE(order->lossless);
  deliver_and_acknowledge(*order);
  frames_.set_interaction(false, now_);
  EXPECT_FALSE(frames_.next(now_));
  tick(FrameScheduler::kSettle);
  EXPECT_TRUE(frames_.next(now_)->lossless);
}

TEST_F(Scheduler, OneOrderAtATimeAndCreditsBoundWhatIsUnderWay) {
  deliver_and_acknowledge(*frames_.next(now_));
  change();
  ASSERT_TRUE(frames_.next(now_));
  change();
  EXPECT_FALSE(frames_.next(now_));
  frames_.started(revision_);
  int given = 1;
  for (int i = 0; i < 20; ++i, change())
    if (frames_.next(now_)) {
      frames_.started(revision_);
      ++given;
    }
  EXPECT_EQ(given, frames_.window());
}

TEST_F(Scheduler, AFrameThatBeginsWithAChangeThatCameAfterItsOrderIsNotDrawnTwice) {
  deliver_and_acknowledge(*frames_.next(now_));
  change();
  const auto order = frames_.next(now_);
  change();
  const auto id = deliver(*order);
  EXPECT_FALSE(frames_.next(now_)) << "it shows the newest state";
  frames_.acknowledged(id, now_);
  EXPECT_FALSE(frames_.next(now_));
  tick(FrameScheduler::kSettle);
  EXPECT_TRUE(frames_.next(now_)->lossless) << "the state's exact picture comes all the same";
}

TEST_F(Scheduler, AFrameThatBeginsAfterAChangeThatItCannotShowIsFollowedByAnother) {
  deliver_and_acknowledge(*frames_.next(now_));
  change();
  auto order = frames_.next(now_);
  change();
  frames_.set_viewport(320, 240, false, now_);
  frames_.acknowledged(deliver(*order), now_);
  order = frames_.next(now_);
  ASSERT_TRUE(order) << "it has the old size";
  frames_.scene_changed(revision_, true, now_);
  frames_.acknowledged(deliver(*order), now_);
  EXPECT_TRUE(frames_.next(now_)) << "the same revision is to be drawn again";
}

TEST_F(Scheduler, NothingFollowsTheFirstFrameUntilItIsKnownWhatTheLinkCarries) {
  const auto first = frames_.next(now_);
  EXPECT_LT(first->quality, 90) << "a first frame that is cheap on any link";
  const auto id = deliver(*first);
  change();
  EXPECT_FALSE(frames_.next(now_));
  EXPECT_FALSE(frames_.wake_at(now_)) << "only an acknowledgement helps";
  tick(milliseconds(5));
  frames_.acknowledged(id, now_);
  EXPECT_TRUE(frames_.next(now_));
}

TEST_F(Scheduler, NoAcknowledgementForFourSecondsStopsDrawingUntilOneComes) {
  deliver_and_acknowledge(*frames_.next(now_));
  change();
  const auto id = deliver(*frames_.next(now_));
  EXPECT_FALSE(frames_.stalled(now_));
  tick(FrameScheduler::kStall);
  EXPECT_TRUE(frames_.stalled(now_));
  change();
  EXPECT_FALSE(frames_.next(now_));
  EXPECT_FALSE(frames_.wake_at(now_));
  frames_.acknowledged(id, now_);
  EXPECT_TRUE(frames_.next(now_));
}

TEST_F(Scheduler, AHiddenPageGetsNothingAndTheNewestStateWhenItShowsAgain) {
  frames_.set_viewport(640, 480, true, now_);
  change();
  EXPECT_FALSE(frames_.next(now_));
  tick(seconds(5));
  EXPECT_FALSE(frames_.next(now_));
  frames_.set_viewport(640, 480, false, now_);
  EXPECT_TRUE(frames_.next(now_));
}

TEST_F(Scheduler, AFrameOfAnOlderStateIsFollowedByTheNewest) {
  const auto order = frames_.next(now_);
  change();
  frames_.next(now_);
  frames_.started(revision_ - 1);
  frames_.acknowledged(frames_.sent(*order, revision_ - 1, kBytes, now_), now_);
  EXPECT_TRUE(frames_.next(now_)) << "the newest state has not been shown";
}

TEST_F(Scheduler, AnUnstartedLosslessOrderGivesWayToAChange) {
  deliver_and_acknowledge(*frames_.next(now_));
  tick(FrameScheduler::kSettle);
  ASSERT_TRUE(frames_.next(now_)->lossless);
  EXPECT_FALSE(frames_.withdraw_order());
  change();
  EXPECT_TRUE(frames_.withdraw_order());
  const auto order = frames_.next(now_);
  ASSERT_TRUE(order);
  EXPECT_FALSE(order->lossless);
  deliver_and_acknowledge(*order);
  tick(FrameScheduler::kSettle);
  EXPECT_TRUE(frames_.next(now_)->lossless);
}

TEST_F(Scheduler, AStillOfItsOwnSizeComesNowAndDoesNotReplaceTheViewports) {
  deliver_and_acknowledge(*frames_.next(now_));
  frames_.request_still(100, 50);
  const auto still = frames_.next(now_);
  ASSERT_TRUE(still);
  EXPECT_TRUE(still->lossless && still->width == 100 && still->height == 50);
  deliver_and_acknowledge(*still);
  tick(FrameScheduler::kSettle);
  const auto order = frames_.next(now_);
  ASSERT_TRUE(order);
  EXPECT_TRUE(order->lossless && order->width == 640);
}

TEST_F(Scheduler, CreditsFollowTheShortestRoundTrip) {
  frames_.round_trip(milliseconds(5), now_);
  EXPECT_EQ(frames_.window(), 2);
  frames_.round_trip(milliseconds(200), now_);
  EXPECT_EQ(frames_.window(), 2);
  tick(seconds(11));
  frames_.round_trip(milliseconds(100), now_);
  EXPECT_EQ(frames_.window(), 4);
  tick(seconds(11));
  frames_.round_trip(seconds(2), now_);
  EXPECT_EQ(frames_.window(), FrameScheduler::kMaxWindow);
}

TEST_F(Scheduler, OnASlowLinkPicturesShrinkWhileTheyMoveAndSettleBeforeTheyAreExact) {
  frames_.round_trip(milliseconds(1), now_);
  learn_link(milliseconds(200));
  change();
  auto order = frames_.next(now_);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->phase, FramePhase::moving);
  EXPECT_LT(order->width, 640);
  EXPECT_NEAR(static_cast<double>(order->width) / order->height, 640.0 / 480, 0.02);
  EXPECT_GT(order->bitrate_kbps, 0);
  deliver_and_acknowledge(*order);
  tick(FrameScheduler::kSettle);
  order = frames_.next(now_);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->phase, FramePhase::settled);
  EXPECT_EQ(order->width, 640);
  EXPECT_EQ(order->quality, 90);
  deliver_and_acknowledge(*order);
  order = frames_.next(now_);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->phase, FramePhase::lossless);
  EXPECT_TRUE(order->lossless);
  deliver_and_acknowledge(*order);
  tick(seconds(10));
  EXPECT_FALSE(frames_.next(now_));
}

TEST_F(Scheduler, AHandThatHoldsStillSeesTheSettledPictureAndNotTheLosslessOne) {
  frames_.round_trip(milliseconds(1), now_);
  learn_link(milliseconds(200));
  frames_.set_interaction(true, now_);
  change();
  deliver_and_acknowledge(*frames_.next(now_));
  tick(FrameScheduler::kSettle);
  const auto order = frames_.next(now_);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->phase, FramePhase::settled);
  deliver_and_acknowledge(*order);
  tick(seconds(10));
  EXPECT_FALSE(frames_.next(now_));
}

TEST_F(Scheduler, FramesWaitHereAsTheNewestStateAndNotOnTheLink) {
  frames_.round_trip(milliseconds(1), now_);
  learn_link(milliseconds(100));
  change();
  deliver(*frames_.next(now_));
  change();
  EXPECT_FALSE(frames_.next(now_)) << "the link is busy with the one before";
  const auto wake = frames_.wake_at(now_);
  ASSERT_TRUE(wake);
  EXPECT_GT(*wake, now_);
  now_ = *wake;
  EXPECT_TRUE(frames_.next(now_)) << "before the one before has been acknowledged, but when the link is about to be free";
}

TEST_F(Scheduler, AcknowledgingWhatWasNeverSentDoesNothing) {
  deliver(*frames_.next(now_));
  frames_.acknowledged(1000000, now_);
  EXPECT_EQ(frames_.in_flight(), 1);
}

TEST_F(Scheduler, AFailedFrameIsNotAskedForAgainUntilSomethingChanges) {
  ASSERT_TRUE(frames_.next(now_));
  frames_.failed(false);
  EXPECT_FALSE(frames_.next(now_));
  change();
  EXPECT_TRUE(frames_.next(now_));
}

}  // namespace
}  // namespace isostrata
