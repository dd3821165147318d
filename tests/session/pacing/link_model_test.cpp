#include "session/pacing/link_model.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace isostrata {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr auto kTrip = milliseconds(80);

/// A link of 80 ms and 250 bytes a millisecond, and what the client would acknowledge when.
class Link : public ::testing::Test {
 protected:
  Link() { model_.round_trip(kTrip, now_); }
  void send(std::size_t bytes) {
    model_.sent(++frame_, bytes, now_);
    passed_ = std::max(passed_, now_) + milliseconds(bytes / 250);
  }
  void hear() {
    now_ = std::max(now_, passed_ + kTrip);
    model_.acknowledged(frame_, {}, now_);
  }
  double rate() const { return model_.bytes_per_second(now_); }

  LinkModel model_;
  TimePoint now_ = TimePoint{} + seconds(100);
  TimePoint passed_{};
  std::uint64_t frame_ = 0;
};

TEST_F(Link, ALoneFrameTellsTheRateAlthoughTheLinkWasIdle) {
  EXPECT_EQ(rate(), 0);
  send(25000);
  hear();
  EXPECT_NEAR(rate(), 250e3, 1);
  now_ += seconds(5);
  send(500);
  hear();
  EXPECT_NEAR(rate(), 250e3, 1) << "small ones too, and after a rest";
}

TEST_F(Link, FramesBehindOthersTellTheRateAndHowLongTheyWaited) {
  send(25000);
  const auto first = passed_;
  send(12500);
  const auto second = passed_;
  model_.acknowledged(1, {}, first + kTrip);
  now_ = second + kTrip;
  model_.acknowledged(2, {}, now_);
  EXPECT_NEAR(rate(), 250e3, 1);
  EXPECT_EQ(model_.queue_delay(), milliseconds(100) / 4) << "a quarter of it so far";
}

TEST_F(Link, IsFreeWhenWhatWasSentHasPassed) {
  send(25000);
  hear();
  now_ += seconds(1);
  EXPECT_LE(model_.free_at(now_), now_);
  send(25000);
  EXPECT_NEAR(std::chrono::duration<double>(model_.free_at(now_) - now_).count(), 0.1, 1e-6);
  send(50000);
  EXPECT_NEAR(std::chrono::duration<double>(model_.free_at(now_) - now_).count(), 0.3, 1e-6);
}

TEST_F(Link, AnAcknowledgementThatIsOverdueIsASlowerLink) {
  send(25000);
  hear();
  send(25000);
  now_ += kTrip + milliseconds(100);
  EXPECT_NEAR(rate(), 250e3, 1) << "due just now";
  now_ += milliseconds(800);
  EXPECT_LT(rate(), 125e3);
  EXPECT_GE(model_.free_at(now_), now_ - kTrip);
  model_.acknowledged(frame_, {}, now_);
  EXPECT_LT(rate(), 60e3);
}

TEST_F(Link, DecodingIsTheClientsTimeAndNotTheWays) {
  send(25000);
  now_ = passed_ + kTrip + milliseconds(40);
  model_.acknowledged(frame_, milliseconds(40), now_);
  EXPECT_NEAR(rate(), 250e3, 1);
}

TEST_F(Link, OneSmallFrameThatIsVeryLateIsDoubtedAndTwoAreBelieved) {
  send(25000);
  hear();
  const auto late = [&] {
    send(1000);
    now_ = passed_ + kTrip + milliseconds(200);
    passed_ = now_ - kTrip;
    model_.acknowledged(frame_, {}, now_);
  };
  const auto on_time = [&] {
    send(1000);
    hear();
  };
  for (int i = 0; i < 5; ++i) {
    late();
    EXPECT_NEAR(rate(), 250e3, 1) << "a thread that slept";
    on_time();
    EXPECT_NEAR(rate(), 250e3, 1);
  }
  late();
  late();
  EXPECT_LT(rate(), 125e3);
}

TEST_F(Link, SmallFramesThatQueueOneByOneTellOfASlowerLinkTogether) {
  send(25000);
  hear();
  const auto begin = now_;
  for (int i = 0; i < 6; ++i) {  // ten milliseconds of the rate that is known, and each is late by less than would be doubted
    model_.sent(++frame_, 2500, begin + i * milliseconds(15));
    now_ = begin + kTrip + (i + 1) * milliseconds(40);
    model_.acknowledged(frame_, {}, now_);
  }
  EXPECT_LT(rate(), 80e3);
}

TEST_F(Link, ADecoderThatFallsBehindIsAQueueToo) {
  for (int i = 0; i < 4; ++i) {
    send(2500);
    now_ = passed_ + kTrip + milliseconds(10);
    model_.acknowledged(frame_, milliseconds(10), now_);
  }
  EXPECT_NEAR(rate(), 250e3, 1);
  for (int i = 0; i < 4; ++i) {
    send(2500);
    now_ = passed_ + kTrip + milliseconds(60 + 40 * i);
    model_.acknowledged(frame_, milliseconds(60 + 40 * i), now_);
  }
  EXPECT_LT(rate(), 60e3) << "to send more would be of no use";
}

TEST_F(Link, AClientThatSaysItDecodesForHoursIsNotBelieved) {
  send(25000);
  now_ += milliseconds(200);
  model_.acknowledged(frame_, std::chrono::hours(5), now_);
  EXPECT_GT(rate(), 0);
  EXPECT_GE(model_.shortest_round_trip(), Duration::zero());
  EXPECT_LE(model_.free_at(now_), now_);
}

TEST_F(Link, OneAcknowledgementStandsForAllBefore) {
  for (int i = 0; i < 5; ++i) send(5000);
  hear();
  EXPECT_EQ(model_.in_flight(), 0u);
  EXPECT_NEAR(rate(), 250e3, 1);
  model_.acknowledged(3, {}, now_);
  model_.acknowledged(99, {}, now_);
  EXPECT_NEAR(rate(), 250e3, 1) << "what is unknown changes nothing";
}

TEST_F(Link, TheShortestRoundTripIsOfTheLastTenSeconds) {
  model_.round_trip(milliseconds(30), now_);
  EXPECT_EQ(model_.shortest_round_trip(), milliseconds(30));
  now_ += seconds(9);
  model_.round_trip(milliseconds(90), now_);
  EXPECT_EQ(model_.shortest_round_trip(), milliseconds(30));
  now_ += seconds(2);
  model_.round_trip(milliseconds(120), now_);
  EXPECT_EQ(model_.shortest_round_trip(), milliseconds(90));
}

}  // namespace
}  // namespace isostrata
