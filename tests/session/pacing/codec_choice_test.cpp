// Laws of choosing by forecasts, on a ticked clock.
#include "session/pacing/codec_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "session/pacing/codec_costs.h"

namespace isostrata {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Codec kJpeg = Codec::jpeg, kVideo = Codec::vp9_444;
constexpr milliseconds kTick{40};

CodecCandidate whole(Codec codec, double making_ms, double passing_ms = 0, double likeness = 1) {
  return {codec, 1, making_ms, passing_ms, likeness};
}

class Choice : public ::testing::Test {
 protected:
  /// Every 40 ms for so long; what is in use in the end.
  CodecCandidate run(const std::vector<CodecCandidate>& candidates, Duration time) {
    std::size_t place = 0;
    for (const TimePoint end = now_ + time; now_ < end; now_ += kTick) {
      const Codec before = choice_.codec();
      const double scale = choice_.scale();
      place = choice_.choose(candidates, now_);
      EXPECT_EQ(candidates[place].codec, choice_.codec());
      if (choice_.codec() != before || choice_.scale() != scale) changes_.push_back(now_);
    }
    return candidates[place];
  }
  double least(const std::vector<CodecCandidate>& candidates) const {
    double ms = 1e9;
    for (const CodecCandidate& of : candidates) ms = std::min(ms, of.ms());
    return ms;
  }

  CodecChoice choice_;
  TimePoint now_ = TimePoint{} + std::chrono::hours(1);
  std::vector<TimePoint> changes_;
};

TEST_F(Choice, IsNeverMoreThanATenthWorseThanTheLeastOnceItHasHadTheTime) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> ms(5, 75), part(0.1, 1);
  for (int world = 0; world < 500; ++world) {
    const std::vector<CodecCandidate> candidates{whole(kJpeg, ms(random), ms(random), part(random)),
                                                 whole(kVideo, ms(random), ms(random), part(random))};
    run(candidates, CodecChoice::kLastRegret + seconds(2));  // whatever was a mistake before may be right in this world
    const CodecCandidate used = run(candidates, kTick);
    EXPECT_LE(used.ms(), CodecChoice::kWorse * least(candidates)) << "world " << world << " of seed 11";
  }
}

TEST_F(Choice, AtTheMomentOfAChangeItIsTheLeastOrNearlyAndABetterPicture) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> ms(5, 75), part(0.1, 1);
  int changes = 0;
  for (int world = 0; world < 2000; ++world) {
    const std::vector<CodecCandidate> candidates{whole(kJpeg, ms(random), 0, part(random)),
                                                 whole(kVideo, ms(random), 0, part(random))};
    for (int tick = 0; tick < 60; ++tick, now_ += kTick) {
      const Codec before = choice_.codec();
      const CodecCandidate used = candidates[choice_.choose(candidates, now_)];
      if (used.codec == before) continue;
      ++changes;
      EXPECT_LE(used.ms(), 1.10 * least(candidates)) << "world " << world << " of seed 12";
    }
  }
  EXPECT_GT(changes, 200);
}

TEST_F(Choice, ChangesAtMostOnceASecondHoweverForecastsJump) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> ms(5, 75);
  for (const auto period : {kTick, milliseconds(240), milliseconds(800), milliseconds(1200)})
    for (const TimePoint end = now_ + seconds(100); now_ < end;)
      run({whole(kJpeg, ms(random)), whole(kVideo, ms(random))}, period);
  ASSERT_GT(changes_.size(), 10u) << "nothing ever changed: the test shows nothing";
  for (std::size_t i = 8; i < changes_.size(); ++i) EXPECT_GE(changes_[i] - changes_[i - 8], seconds(4)) << "nine changes";
}

TEST_F(Choice, ForecastsThatWaverAboutEachOtherChangeNothing) {
  run({whole(kJpeg, 20), whole(kVideo, 30)}, seconds(2));
  for (int i = 0; i < 100; ++i) {
    run({whole(kJpeg, 20), whole(kVideo, 18.5)}, milliseconds(160));
    run({whole(kJpeg, 18.5), whole(kVideo, 20)}, milliseconds(160));
  }
  EXPECT_TRUE(changes_.empty());
}

TEST_F(Choice, OfTwoThatAreAsSoonTheBetterPictureIsShown) {
  EXPECT_EQ(run({whole(kJpeg, 10, 100, 0.5), whole(kVideo, 14, 100)}, seconds(3)).codec, kVideo);
  EXPECT_EQ(run({whole(kJpeg, 10, 100, 0.5), whole(kVideo, 17, 100)}, seconds(3)).codec, kVideo) << "it stays";
  EXPECT_EQ(run({whole(kJpeg, 10, 100, 0.5), whole(kVideo, 40, 100)}, seconds(3)).codec, kJpeg);
}

TEST_F(Choice, OfTwoThatAreAsSoonTheOneOfFarFewerBytesIsShownWhereTheyTakeTime) {
  const auto candidates = [](double jpeg_line_ms) {
    std::vector<CodecCandidate> both{whole(kJpeg, 20, 60), whole(kVideo, 22, 60)};
    both[0].line_ms = jpeg_line_ms;
    both[1].line_ms = jpeg_line_ms / 5;
    return both;
  };
  EXPECT_EQ(run(candidates(1), seconds(5)).codec, kJpeg) << "on a fast line bytes are not a reason";
  EXPECT_EQ(run(candidates(20), seconds(5)).codec, kVideo);
  EXPECT_EQ(run(candidates(6), seconds(5)).codec, kVideo) << "and none to go back";
  EXPECT_EQ(changes_.size(), 1u);
}

TEST_F(Choice, AtRestTheSizeIsChosenAnewWithoutPatienceAndInAGestureNot) {
  const auto sizes = [](double whole_ms) {
    std::vector<CodecCandidate> candidates;
    for (const double scale : {1.0, 0.65, 0.4}) candidates.push_back({kJpeg, scale, whole_ms * scale * scale, 0, scale * scale});
    return candidates;
  };
  const auto anew = [&](double whole_ms) {
    const auto candidates = sizes(whole_ms);
    return candidates[choice_.choose_anew(candidates, now_)].scale;
  };
  EXPECT_EQ(anew(20), 1);
  EXPECT_EQ(anew(60), 0.65) << "the first picture already fits";
  EXPECT_EQ(anew(150), 0.4);
  EXPECT_EQ(anew(20), 1) << "and the next one is whole again";
  const auto slow = sizes(60);
  EXPECT_EQ(slow[choice_.choose(slow, now_ += kTick)].scale, 1) << "one forecast is not a reason while somebody looks";
}

TEST_F(Choice, AMistakeIsLeftAtOnceAndNotRepeatedSoon) {
  bool looks_good = true;
  int tried = 0;
  Duration with_it{};
  for (const TimePoint end = now_ + seconds(60); now_ < end; now_ += kTick) {
    const bool before = choice_.codec() == kVideo;
    // It promises much whenever it is not in use.
    looks_good = !before;
    choice_.choose({whole(kJpeg, 20), whole(kVideo, looks_good ? 15 : 60)}, now_);
    tried += choice_.codec() == kVideo && !before;
    if (before) with_it += kTick;
  }
  EXPECT_GE(tried, 2) << "but it is tried again: times change";
  EXPECT_LE(tried, 5);
  EXPECT_LE(with_it, milliseconds(280) * tried);
}

TEST_F(Choice, WhatCannotBeHadAnyMoreIsLeftAtOnce) {
  run({whole(kJpeg, 60), whole(kVideo, 20)}, seconds(3));
  ASSERT_EQ(choice_.codec(), kVideo);
  EXPECT_EQ(run({whole(kJpeg, 60)}, kTick).codec, kJpeg);
}

/// Both codecs at several sizes; making takes so much for a whole picture, of which `part` is in proportion to pixels.
std::vector<CodecCandidate> sizes(double jpeg_ms, double video_ms, double part) {
  std::vector<CodecCandidate> all;
  for (const auto& [codec, ms] : {std::pair{kJpeg, jpeg_ms}, {kVideo, video_ms}})
    for (const double scale : {1.0, 0.8, 0.65, 0.5, 0.4, 0.3})
      all.push_back({codec, scale, ms * (1 - part + part * scale * scale), 5, scale * scale});
  return all;
}

TEST_F(Choice, PixelsAreGivenUpWhereThatMakesFramesInTimeAndTakenBack) {
  EXPECT_EQ(run(sizes(30, 50, 0.9), seconds(5)).scale, 1) << "30 ms are in time";
  const CodecCandidate less = run(sizes(160, 200, 0.9), seconds(5));
  EXPECT_LT(less.scale, 1);
  EXPECT_LE(less.making_ms, CodecChoice::kInTimeMs);
  EXPECT_EQ(run(sizes(20, 50, 0.9), seconds(5)).scale, 1);
}

TEST_F(Choice, PixelsAreGivenUpInAHurryWhereFramesAreFarTooLate) {
  run(sizes(20, 50, 0.9), seconds(5));
  const TimePoint begun = now_;
  changes_.clear();
  run(sizes(160, 200, 0.9), seconds(5));
  ASSERT_FALSE(changes_.empty());
  EXPECT_LE(changes_.front() - begun, CodecChoice::kHurry + 2 * kTick);
  // What is only a little too late is left after some patience.
  run(sizes(20, 50, 0.9), seconds(5));
  const TimePoint again = now_;
  changes_.clear();
  run(sizes(38, 60, 0.9), seconds(5));
  ASSERT_FALSE(changes_.empty());
  EXPECT_GE(changes_.front() - again, CodecChoice::kPatience);
}

TEST_F(Choice, PixelsAreKeptWhereFewerWouldNotHelp) { EXPECT_EQ(run(sizes(160, 200, 0.1), seconds(5)).scale, 1); }

TEST_F(Choice, ASizeAtTheEdgeDoesNotFlicker) {
  for (int i = 0; i < 100; ++i) {
    run(sizes(78, 120, 0.9), milliseconds(400));
    run(sizes(84, 120, 0.9), milliseconds(400));
    run(sizes(84, 120, 0.9), milliseconds(400));
  }
  EXPECT_LE(changes_.size(), 2u);
}

TEST(CodecCosts, TellOfTheOtherCodecByTheLoadOfNow) {
  CodecCosts costs(2.5);
  TimePoint now = TimePoint{} + std::chrono::hours(1);
  const auto run = [&](Codec codec, double cost) {
    for (int i = 0; i < 60; ++i, now += milliseconds(33)) costs.measured(codec, cost, now);
  };
  EXPECT_EQ(costs.expected(kJpeg, now), 0);
  run(kJpeg, 2);
  EXPECT_NEAR(costs.expected(kVideo, now), 5, 0.01) << "what is usual";
  run(kVideo, 12);
  EXPECT_NEAR(costs.expected(kVideo, now), 12, 0.1);
  EXPECT_NEAR(costs.expected(kJpeg, now), 2, 0.1);
  run(kVideo, 60);  // a neighbour has come
  run(kVideo, 60);
  EXPECT_NEAR(costs.expected(kJpeg, now), 10, 1);
  for (int minute = 0; minute < 5; ++minute)
    for (int i = 0; i < 60; ++i, now += seconds(1)) costs.measured(kVideo, 12, now);
  EXPECT_NEAR(costs.expected(kJpeg, now), 12 / 2.5, 0.2) << "what was learned long ago gives way to what is usual";
}

TEST(CodecCosts, WhatVariesCostsMoreThanItsMean) {
  CodecCosts costs(2.5);
  TimePoint now = TimePoint{} + std::chrono::hours(1);
  for (int i = 0; i < 60; ++i, now += milliseconds(33)) costs.measured(kJpeg, i % 2 ? 2 : 22, now);
  EXPECT_GT(costs.expected(kJpeg, now), 18);
  EXPECT_LT(costs.expected(kJpeg, now), 26);
}

TEST(PixelShare, IsLearnedWhereTheSizeChanges) {
  TimePoint now = TimePoint{} + std::chrono::hours(1);
  for (const double part : {0.0, 0.5, 1.0}) {
    PixelShare share;
    for (const double pixels : {1.0, 0.25})
      for (int i = 0; i < 20; ++i, now += milliseconds(33)) share.measured(100 * (1 - part + part * pixels), pixels, now);
    EXPECT_NEAR(share.scaled(100 * (1 - part + part * 0.25), 0.25, 1, now), 100, 5) << part;
    EXPECT_NEAR(share.scaled(100, 1, 0.64, now), 100 * (1 - part + part * 0.64), 5) << part;
  }
}

}  // namespace
}  // namespace isostrata
