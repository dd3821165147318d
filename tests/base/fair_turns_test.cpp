#include "base/fair_turns.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <vector>

namespace isostrata {
namespace {

using namespace std::chrono_literals;

/// One core, fake work and a clock that is ticked.
class FairTurnsTest : public ::testing::Test {
 protected:
  static constexpr FairTurns::Time kTick = 1ms, kForever = 1h;
  struct Job {
    FairTurns::Id id = 0;
    FairTurns::Time left{0}, done{0}, began{0}, ended{0};
    bool goes_on = true;  // says so at every tick in which it has the turn
  };

  /// By its place in jobs_.
  std::size_t begin(std::uint64_t session, WorkClass of, FairTurns::Time lasts = kForever) {
    jobs_.push_back({turns_.begin(session, of, now_), lasts, 0ms, now_, 0ms, true});
    return jobs_.size() - 1;
  }
  void end(std::size_t job) {
    turns_.end(jobs_[job].id, now_);
    jobs_[job].left = 0ms;
    jobs_[job].ended = now_;
  }
  Job* holder() {
    const FairTurns::Id id = turns_.holder(now_);
    for (Job& job : jobs_)
      if (id != 0 && job.id == id) return &job;
    return nullptr;
  }
  void pass(FairTurns::Time time) {
    for (FairTurns::Time passed{0}; passed < time; passed += kTick) {
      Job* const job = holder();
      now_ += kTick;
      if (!job) {
        for (const Job& waits : jobs_) ASSERT_LE(waits.left, 0ms) << "nobody has the turn";
        continue;
      }
      if (job->goes_on) turns_.step(job->id);
      job->done += kTick;
      job->left -= kTick;
      if (job->left <= 0ms) end(static_cast<std::size_t>(job - jobs_.data()));
    }
  }

  FairTurns turns_;
  FairTurns::Time now_ = 5s;
  std::vector<Job> jobs_;
};

TEST_F(FairTurnsTest, WhoeverIsAloneHasTheTurnAndNobodyHasItWhereNobodyWorks) {
  EXPECT_EQ(holder(), nullptr);
  const auto alone = begin(1, WorkClass::background, 200ms);
  pass(200ms);
  EXPECT_EQ(jobs_[alone].done, 200ms);
  EXPECT_EQ(holder(), nullptr);
}

TEST_F(FairTurnsTest, MoreUrgentWorkTakesTheTurnAtOnce) {
  begin(1, WorkClass::background);
  pass(2ms);
  const auto still = begin(2, WorkClass::still);
  EXPECT_EQ(holder(), &jobs_[still]);
  pass(2ms);
  const auto frame = begin(3, WorkClass::frame);
  EXPECT_EQ(holder(), &jobs_[frame]);
}

TEST_F(FairTurnsTest, APictureThatIsDrawnBecomesBytesBeforeTheNextOneIsDrawn) {
  begin(1, WorkClass::frame);
  pass(2ms);
  const auto bytes = begin(1, WorkClass::encoding, 3ms);
  EXPECT_EQ(holder(), &jobs_[bytes]);
  pass(3ms);
  EXPECT_EQ(jobs_[bytes].ended - jobs_[bytes].began, 3ms);
}

TEST_F(FairTurnsTest, SessionsHaveTheSameTimeHoweverManyWorksTheyHave) {
  for (int i = 0; i < 5; ++i) begin(1, WorkClass::still);
  const auto other = begin(2, WorkClass::still);
  pass(3s);
  FairTurns::Time of_first{0};
  for (std::size_t i = 0; i < 5; ++i) of_first += jobs_[i].done;
  EXPECT_LE(of_first - jobs_[other].done, FairTurns::kTurn);
  EXPECT_LE(jobs_[other].done - of_first, FairTurns::kTurn);
}

// A session whose frames are heavy, and another one's that are not.
TEST_F(FairTurnsTest, ShortFramesBesideLongWorkOfTheirClassAreDrawnAtOnce) {
  begin(1, WorkClass::frame);
  pass(1s);
  for (int i = 0; i < 20; ++i) {
    const auto frame = begin(2, WorkClass::frame, 20ms);
    pass(100ms);
    EXPECT_EQ(jobs_[frame].ended - jobs_[frame].began, 20ms) << "frame " << i;
  }
}

TEST_F(FairTurnsTest, FramesThatLeaveTimeAreNeverMadeToWaitForStills) {
  begin(1, WorkClass::still);
  for (int i = 0; i < 50; ++i) {
    const auto frame = begin(2, WorkClass::frame, 30ms);
    pass(80ms);
    EXPECT_EQ(jobs_[frame].ended - jobs_[frame].began, 30ms) << "frame " << i;
  }
  EXPECT_EQ(jobs_[0].done, 50 * 50ms);
}

TEST_F(FairTurnsTest, LessUrgentWorkGetsAQuarterOfTheTimeHoweverMuchIsDrawn) {
  const auto frames = begin(1, WorkClass::frame);
  const auto still = begin(2, WorkClass::still);
  pass(4s);
  EXPECT_GE(jobs_[still].done, 900ms);
  EXPECT_LE(jobs_[still].done, 1100ms);
  EXPECT_EQ(jobs_[frames].done + jobs_[still].done, 4s);
}

TEST_F(FairTurnsTest, WhatNobodyWaitsForGetsASixteenthOfTheTimeAndAllThatIsLeft) {
  const auto frames = begin(1, WorkClass::frame, 4s);
  const auto idle = begin(2, WorkClass::idle);
  pass(3s);
  EXPECT_GE(jobs_[idle].done, 150ms);
  EXPECT_LE(jobs_[idle].done, 200ms);
  pass(5s);
  EXPECT_EQ(jobs_[frames].left, 0ms);
  EXPECT_EQ(jobs_[idle].done, 4s);
}

TEST_F(FairTurnsTest, WhatUrgentWorkWaitsForIsAsUrgent) {
  const auto still = begin(1, WorkClass::still), made_ahead = begin(0, WorkClass::idle, 100ms), waits = begin(2, WorkClass::scene);
  pass(1s);
  EXPECT_LE(jobs_[made_ahead].done, 1000ms / 16 + FairTurns::kTurn);
  jobs_[waits].goes_on = false;
  const auto left = jobs_[made_ahead].left;
  turns_.lend_urgency(jobs_[waits].id, jobs_[made_ahead].id, now_);
  turns_.lend_urgency(jobs_[still].id, jobs_[made_ahead].id, now_);  // makes nothing less urgent
  pass(3 * left);  // the still is due meanwhile
  EXPECT_LE(jobs_[made_ahead].left, 0ms);
  turns_.lend_urgency(jobs_[waits].id, jobs_[made_ahead].id, now_);  // it has ended
}

TEST_F(FairTurnsTest, WorkThatDoesNotGoOnLosesItsTurnUntilItDoes) {
  const auto hangs = begin(1, WorkClass::frame), other = begin(2, WorkClass::background);
  jobs_[hangs].goes_on = false;
  pass(1s);
  EXPECT_LE(jobs_[hangs].done, FairTurns::kTurn);
  turns_.step(jobs_[hangs].id);
  EXPECT_EQ(holder(), &jobs_[hangs]);
  EXPECT_GE(jobs_[other].done, 1s - FairTurns::kTurn);
}

TEST_F(FairTurnsTest, ASessionThatWasAwayHasSavedUpNoMoreThanTheCredit) {
  begin(1, WorkClass::frame, 10ms);
  pass(10ms);
  const auto busy = begin(2, WorkClass::frame);
  pass(10s);
  const auto back = begin(1, WorkClass::frame);
  pass(1s);
  EXPECT_LE(jobs_[back].done, 500ms + FairTurns::kCredit);
  EXPECT_GE(jobs_[busy].done, 10s + 500ms - FairTurns::kCredit);
}

TEST_F(FairTurnsTest, NoTimeIsLostAndEverythingEnds) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    jobs_.clear();
    std::mt19937 random(seed);
    for (int i = 0; i < 60; ++i) {
      begin(random() % 5, static_cast<WorkClass>(random() % 6), std::chrono::milliseconds(1 + random() % 100));
      pass(std::chrono::milliseconds(random() % 60));
    }
    pass(60 * 100ms);
    for (const Job& job : jobs_) EXPECT_EQ(job.left, 0ms) << "seed " << seed;
  }
}

}  // namespace
}  // namespace isostrata
