// A dataset that is opened, waited for, rewritten, grown and deleted, on a clock that the test moves and with an engine that answers when the
// test says so.
#include "session/datasets/session_dataset.h"

#include <gtest/gtest.h>

#include <map>

#include "session/asked_engine.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

/// With a catalogue that is what the test says.
struct EngineWithFiles final : AskedEngine {
  const CatalogueEntry* entry(const std::string& dataset) const override {
    const auto it = entries.find(dataset);
    return it == entries.end() ? nullptr : &it->second;
  }
  std::string newest(const std::string& dataset) override {
    const CatalogueEntry* of = entry(dataset);
    return of ? version_id(*of) : dataset;
  }
  std::map<std::string, CatalogueEntry> entries;
};

class DatasetOfASession : public ::testing::Test, protected SessionDataset::Audience {
 protected:
  DatasetOfASession() {
    for (const char* id : {"plume", "other"}) engine_.entries[id] = {.id = id, .name = id};
  }

  void in_use(TimePoint) override {}
  void tell(const v1::ServerMessage& message) override {
    if (message.has_progress()) log("progress");
    if (message.has_done()) log(message.done().cancelled() ? "done cancelled" : "done");
    if (message.has_dataset_info()) log("info");
  }
  void show_dataset(const SessionDataset::Asker& asker, bool reload, TimePoint) override {
    log((reload ? "reload for " : "show for ") + std::to_string(asker.viewer));
  }
  void opening_ended(TimePoint) override { log("ended"); }
  void ranges_read(std::shared_ptr<const DatasetFacts> before, TimePoint) override { log(before ? "ranges" : "no ranges"); }
  void steps_read(TimePoint) override { log("steps"); }
  void try_drawing_again(TimePoint) override { log("draw"); }
  void log(const std::string& what) { heard_ += heard_.empty() ? what : ", " + what; }
  std::string heard() { return std::exchange(heard_, ""); }

  void open(const std::string& id, ViewerKey viewer = 1, bool reload = false, std::uint64_t command = 0) {
    dataset_.open(id, {viewer, 1, 1, {"client", command}}, reload, now_,
                  [this, id](std::optional<v1::Error> error) { log(id + " " + (error ? error->code() : "done")); });
  }
  static DatasetFacts facts(const std::string& id = "plume", int missing_steps = 0) {
    DatasetFacts facts;
    facts.id = id;
    facts.missing_steps = missing_steps;
    return facts;
  }
  /// Of what was asked for last.
  void answer(const EngineEvent& event) { engine_.answer(engine_.last, event, now_); }
  OpenRequest asked() const { return std::get<OpenRequest>(engine_.asked.back()); }
  void ready(const DatasetFacts& of = facts()) { answer(DatasetReady{1, engine_.last, of}); }
  void fail(ErrorCode code) { answer(RequestFailed{1, engine_.last, 0, code, "why"}); }
  void opened(const DatasetFacts& of = facts()) {
    open(of.id);
    ready(of);
    heard();
  }
  CatalogueEntry& plume() { return engine_.entries["plume"]; }

  TimePoint now_{std::chrono::hours(1)};
  EngineWithFiles engine_;
  std::string heard_;
  SessionDataset dataset_{1, engine_, *this};
};

TEST_F(DatasetOfASession, IsShownBeforeWhoAskedHearsAndBeforeWhatWaitsGoesOn) {
  open("plume", 7);
  EXPECT_TRUE(dataset_.opening());
  EXPECT_EQ(dataset_.facts(), nullptr);
  ready();
  EXPECT_EQ(heard(), "show for 7, plume done, ended");
  EXPECT_FALSE(dataset_.opening());
  EXPECT_TRUE(dataset_.is_open("plume", false));
  EXPECT_TRUE(dataset_.is_open("plume", true)) << "the file is as it was read";
  EXPECT_FALSE(dataset_.is_open("other", false));
  EXPECT_EQ(dataset_.version(), "plume");
}

TEST_F(DatasetOfASession, AFailureLeavesTheOneThatIsOpen) {
  opened();
  open("other");
  fail(ErrorCode::bad_data);
  EXPECT_EQ(heard(), "other bad_data, ended");
  EXPECT_TRUE(dataset_.is_open("plume", false));
}

TEST_F(DatasetOfASession, AnotherOneOvertakesTheOneThatIsBeingOpened) {
  open("plume");
  open("other");
  EXPECT_EQ(heard(), "plume cancelled, ended");
  ASSERT_EQ(engine_.posted.size(), 1u);
  EXPECT_TRUE(std::get<CancelRequest>(engine_.posted[0]).superseded);
  EXPECT_EQ(std::get<CancelRequest>(engine_.posted[0]).request, 1u);
  EXPECT_EQ(engine_.listeners.size(), 1u) << "the answer for the first finds nobody";
  ready(facts("other"));
  EXPECT_EQ(heard(), "show for 1, other done, ended");
}

TEST_F(DatasetOfASession, WhoAsksForTheSameWaitsWithTheFirstAndTakesItsPlace) {
  open("plume", 1, false, 5);
  open("plume", 2, false, 3);
  open("plume", 0);
  EXPECT_EQ(engine_.asked.size(), 1u);
  EXPECT_EQ(dataset_.opening_command(), (CommandNumber{"client", 5})) << "which is not settled before it is open";
  ready();
  EXPECT_EQ(heard(), "show for 2, plume done, plume done, plume done, ended");
  EXPECT_EQ(dataset_.opening_command(), CommandNumber{});
}

TEST_F(DatasetOfASession, AFileThatIsBeingWrittenIsWaitedForAndReadOnceItIsComplete) {
  plume().writing = true;
  open("plume");
  fail(ErrorCode::bad_data);
  EXPECT_EQ(heard(), "progress");
  EXPECT_TRUE(dataset_.opening());
  EXPECT_EQ(dataset_.opening_request(), 0u);
  now_ += std::chrono::hours(1);
  dataset_.look_at_waiting(now_);
  dataset_.look_at_files(now_);
  EXPECT_EQ(heard(), "");
  plume().writing = false;
  dataset_.look_at_files(now_);
  EXPECT_EQ(heard(), "done");
  EXPECT_EQ(engine_.asked.size(), 2u);
  ready();
  EXPECT_EQ(heard(), "show for 1, plume done, ended");
}

TEST_F(DatasetOfASession, WaitingForAFileEndsOnNobodysWordWhenAnotherDatasetIsAskedFor) {
  plume().writing = true;
  open("plume");
  fail(ErrorCode::bad_data);
  EXPECT_EQ(heard(), "progress");
  open("other");
  EXPECT_EQ(heard(), "done, plume cancelled, ended");
}

TEST_F(DatasetOfASession, AFileThatWasReadInABadMomentIsTriedAgainForSecondsAndNoLonger) {
  open("plume");
  fail(ErrorCode::unavailable);
  EXPECT_EQ(heard(), "progress");
  now_ += std::chrono::milliseconds(2900);
  dataset_.look_at_waiting(now_);
  EXPECT_EQ(heard(), "") << "the catalogue may hear of it a little later";
  now_ += std::chrono::milliseconds(200);
  dataset_.look_at_waiting(now_);
  EXPECT_EQ(heard(), "done, plume unavailable, ended");
  EXPECT_FALSE(dataset_.opening());
}

TEST_F(DatasetOfASession, AFileThatHasChangedSinceItWasAskedForIsReadAtOnce) {
  open("plume");
  plume().version = 1;
  fail(ErrorCode::bad_data);
  EXPECT_EQ(heard(), "");
  ASSERT_EQ(engine_.asked.size(), 2u);
  EXPECT_EQ(asked().dataset, "plume~1");
  fail(ErrorCode::bad_data);
  EXPECT_EQ(heard(), "plume bad_data, ended") << "it is as it was, and bad";
}

TEST_F(DatasetOfASession, WhatNoWaitingMendsFailsAtOnce) {
  plume().writing = true;
  for (const ErrorCode code : {ErrorCode::too_large, ErrorCode::unsupported, ErrorCode::cancelled}) {
    open("plume");
    fail(code);
    EXPECT_EQ(heard(), "plume " + std::string(to_string(code)) + ", ended");
  }
  plume().news = CatalogueNews::gone;
  open("plume");
  fail(ErrorCode::not_found);
  EXPECT_EQ(heard(), "plume not_found, ended");
}

TEST_F(DatasetOfASession, WaitingEndsWhenSomebodyCancelsItOrTheFileIsGone) {
  plume().writing = true;
  std::uint64_t operation = 0;
  for (const bool gone : {false, true}) {
    open("plume");
    fail(ErrorCode::bad_data);
    heard();
    dataset_.cancel(3, now_);
    EXPECT_EQ(heard(), "") << "another operation";
    if (gone) {
      plume().news = CatalogueNews::gone;
      dataset_.look_at_files(now_);
      EXPECT_EQ(heard(), "done, plume bad_data, ended");
    } else {
      for (operation = std::uint64_t{1} << 40; dataset_.opening() && operation < (std::uint64_t{1} << 40) + 100; ++operation) dataset_.cancel(operation, now_);
      EXPECT_EQ(heard(), "done cancelled, plume cancelled, ended");
    }
    EXPECT_FALSE(dataset_.opening());
  }
}

TEST_F(DatasetOfASession, ARewrittenFileIsToldAndReadWhenSomebodyAsksForIt) {
  opened();
  plume().version = 1;
  dataset_.look_at_files(now_);
  EXPECT_EQ(heard(), "info");
  EXPECT_EQ(dataset_.facts()->on_disk, OnDisk::changed);
  dataset_.look_at_files(now_);
  EXPECT_EQ(heard(), "") << "told once";
  EXPECT_EQ(dataset_.version(), "plume") << "what is shown does not change";
  EXPECT_TRUE(dataset_.is_open("plume", false));
  EXPECT_FALSE(dataset_.is_open("plume", true));
  open("plume", 1, true);
  EXPECT_EQ(asked().dataset, "plume~1");
  ready();
  EXPECT_EQ(heard(), "reload for 1, plume done, ended");
  EXPECT_EQ(dataset_.version(), "plume~1");
  EXPECT_EQ(dataset_.facts()->on_disk, OnDisk::as_read);
}

TEST_F(DatasetOfASession, ADeletedFileIsShownFromMemoryAndNotReadAgain) {
  opened();
  plume().news = CatalogueNews::gone;
  dataset_.look_at_files(now_);
  EXPECT_EQ(heard(), "info");
  EXPECT_EQ(dataset_.facts()->on_disk, OnDisk::gone);
  EXPECT_TRUE(dataset_.is_open("plume", true));
  plume().news = CatalogueNews::none;
  dataset_.look_at_files(now_);
  EXPECT_EQ(dataset_.facts()->on_disk, OnDisk::as_read);
}

TEST_F(DatasetOfASession, ASeriesThatGrowsGainsItsStepsByItselfOneReadingAtATime) {
  opened();
  plume().parts = 2;
  dataset_.look_at_files(now_);
  plume().parts = 3;
  dataset_.look_at_files(now_);
  EXPECT_EQ(engine_.asked.size(), 2u) << "once it is answered it is looked at again";
  ready();
  EXPECT_EQ(heard(), "info, steps");
  ASSERT_EQ(engine_.asked.size(), 3u);
  fail(ErrorCode::unavailable);
  EXPECT_EQ(heard(), "") << "the file says so when it is asked for";
  dataset_.look_at_files(now_);
  ready();
  EXPECT_EQ(heard(), "info, steps");
  EXPECT_EQ(engine_.asked.size(), 4u);
}

TEST_F(DatasetOfASession, NewStepsOfAnOldVersionAreNotMixedIn) {
  opened();
  plume().parts = 2;
  dataset_.look_at_files(now_);
  const RequestId old = engine_.last;
  const auto listener = engine_.listeners.at(old);
  plume().version = 1;
  open("plume", 1, true);
  ready();
  heard();
  listener(DatasetReady{1, old, facts()}, now_);
  EXPECT_EQ(heard(), "");
}

TEST_F(DatasetOfASession, RangesOfAllStepsAreReadBehindAndGivenUpWithTheDataset) {
  open("plume");
  ready(facts("plume", 2));
  EXPECT_EQ(heard(), "show for 1, plume done, ended");
  ASSERT_TRUE(asked().all_ranges);
  EXPECT_EQ(dataset_.reading_ranges(), engine_.last);
  ready();
  EXPECT_EQ(heard(), "info, ranges");
  EXPECT_EQ(dataset_.reading_ranges(), 0u);

  opened(facts("other", 2));
  const RequestId ranges = dataset_.reading_ranges();
  EXPECT_NE(ranges, 0u);
  opened();
  EXPECT_EQ(dataset_.reading_ranges(), 0u);
  EXPECT_FALSE(engine_.listeners.contains(ranges));
  EXPECT_EQ(std::get<CancelRequest>(engine_.posted.back()).request, ranges);

  opened(facts("other", 2));
  fail(ErrorCode::cancelled);
  EXPECT_EQ(heard(), "no ranges");
  EXPECT_EQ(dataset_.facts()->missing_steps, 2) << "they stay what is known";
}

TEST_F(DatasetOfASession, WhatCouldNotBeReadIsTriedAgainWhenTheFilesAreWell) {
  opened();
  dataset_.look_at_files(now_);
  EXPECT_EQ(heard(), "");
  dataset_.note_unread();
  dataset_.look_at_files(now_);
  EXPECT_EQ(heard(), "draw");
  dataset_.look_at_files(now_);
  EXPECT_EQ(heard(), "") << "once";
}

}  // namespace
}  // namespace isostrata
