// Questions without an engine: which memory is borrowed for them, and who waits for whom.
#include "engine/engine/jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <filesystem>
#include <future>

#include "data/dataset/analytic.h"
#include "engine/heard_events.h"
#include "extraction/bricks/brick_memory.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;

constexpr SessionKey kOurs = 1, kTheirs = 2;
constexpr std::uint64_t kQuarter = 300 << 20, kForExport = 200 << 20;

class JobsTest : public ::testing::Test, protected HeardEvents {
 protected:
  struct Loan {
    std::uint64_t bytes = 0;
    std::string what;
  };

  /// lend_: what else happens when somebody asks; it may throw.
  MemoryForJobs memory() {
    MemoryForJobs memory;
    memory.lend = [this](SessionKey, std::uint64_t bytes, const std::string& what) -> std::shared_ptr<void> {
      const std::lock_guard lock(loans_mutex_);
      loans_.push_back({bytes, what});
      if (lend_) lend_();
      return {static_cast<void*>(this), [this](void*) { given_back_ = true, file_at_the_end_ = std::filesystem::exists(mesh()); }};
    };
    memory.lend_what_is_free = [](std::uint64_t) -> std::shared_ptr<void> { throw Error(ErrorCode::unavailable, "nothing is free"); };
    memory.quarter_of_free = [] { return kQuarter; };
    memory.for_export = [this](const ExportRequest& request) {
      if (before_export_) before_export_(request);
      return kForExport;
    };
    return memory;
  }
  std::string mesh() const { return folder_.path() / "layers.vtu"; }
  ExportRequest export_of(SessionKey session, RequestId request) const { return {session, request, scene(1), mesh(), {}}; }
  LayersMeasured measured(const std::shared_ptr<const ExtractedScene>& ready) {
    jobs_.post(MeasureRequest{kOurs, ++request_, scene(7)}, ready);
    return wait_for<LayersMeasured>([&](const LayersMeasured& of) { return of.request == request_; });
  }
  static std::shared_ptr<const ExtractedScene> as_mesh() { return extract_scene(torus(), scene(7), nullptr, Task{}); }
  std::shared_ptr<const ExtractedScene> as_bricks() {
    SceneAids aids;
    aids.bricks = &bricks_;
    aids.least_in_bricks = 0;
    return extract_scene([dataset = torus()](int, const Task&) { return dataset; }, scene(7), nullptr, Task{}, aids);
  }
  static std::shared_ptr<const Dataset> torus() { return make_analytic("torus:12", {}, Task{}); }
  static void refuse() { throw Error(ErrorCode::too_large, "too little is free"); }

  testing::TemporaryFolder folder_;
  std::mutex loans_mutex_;
  std::vector<Loan> loans_;
  std::function<void()> lend_;
  std::function<void(const ExportRequest&)> before_export_;
  std::atomic<bool> given_back_{false}, file_at_the_end_{false};
  RequestId request_ = 100;
  BrickMemory bricks_;
  RunningOperations operations_{[this](EngineEvent event) { note(std::move(event)); }};
  OpenDatasets datasets_{Catalogue::from_sources({"torus:12"}), {}, nullptr};
  Jobs jobs_{{std::uint64_t{1} << 30}, datasets_, operations_, memory(), [this](EngineEvent event) { note(std::move(event)); }};
};

TEST_F(JobsTest, AnExportBorrowsWhatItMayAskForUntilItsFileIsThere) {
  jobs_.post(export_of(kOurs, 1));
  const auto ready = wait_for<ExportReady>([](const ExportReady& of) { return of.request == 1; });
  EXPECT_GT(ready.mesh.tetrahedra, 0);
  ASSERT_EQ(loans_.size(), 1u);
  EXPECT_EQ(loans_[0].bytes, kForExport);
  EXPECT_EQ(loans_[0].what, "this export");
  EXPECT_TRUE(given_back_);
  EXPECT_TRUE(file_at_the_end_) << "it was given back before the file was written";
}

TEST_F(JobsTest, AnExportThatIsLentNothingSaysWhyAndWritesNothing) {
  lend_ = refuse;
  jobs_.post(export_of(kOurs, 1));
  const RequestFailed failed = failure_of(1);
  EXPECT_EQ(failed.code, ErrorCode::too_large);
  EXPECT_THAT(failed.message, HasSubstr("too little is free"));
  EXPECT_FALSE(std::filesystem::exists(mesh()));
}

TEST_F(JobsTest, LayersThatAreReadyAreMeasuredWithoutALoanAndAsThoseThatAreExtractedForIt) {
  const LayersMeasured ready = measured(as_mesh());
  EXPECT_TRUE(loans_.empty());
  const LayersMeasured extracted = measured(nullptr);
  ASSERT_EQ(loans_.size(), 1u);
  EXPECT_EQ(loans_[0].bytes, kQuarter);
  EXPECT_TRUE(given_back_);
  EXPECT_EQ(ready.revision, 7u);
  ASSERT_EQ(ready.intervals.size(), 1u);
  ASSERT_EQ(extracted.intervals.size(), 1u);
  EXPECT_EQ(ready.intervals[0].tetrahedra, extracted.intervals[0].tetrahedra);
  EXPECT_EQ(ready.intervals[0].volume, extracted.intervals[0].volume);
  ASSERT_TRUE(ready.intervals[0].volume_error);
  EXPECT_EQ(ready.intervals[0].volume_error, extracted.intervals[0].volume_error);
}

TEST_F(JobsTest, BricksAreMeasuredByTheirCellsAndWithoutAnEstimateIfThoseDoNotFit) {
  const auto bricks = as_bricks();
  ASSERT_TRUE(bricks->bricks);
  EXPECT_TRUE(measured(bricks).intervals.at(0).volume_error);
  lend_ = refuse;
  EXPECT_FALSE(measured(bricks).intervals.at(0).volume_error);
  jobs_.post(MeasureRequest{kOurs, 1, scene(7)}, nullptr);
  EXPECT_EQ(failure_of(1).code, ErrorCode::too_large) << "nothing is known of layers that are not there";
  lend_ = [] { throw Error(ErrorCode::unavailable, "another reason"); };
  jobs_.post(MeasureRequest{kOurs, 2, scene(7)}, bricks);
  EXPECT_EQ(failure_of(2).code, ErrorCode::unavailable);
}

TEST_F(JobsTest, APlaceIsProbedWhileAnExportOfTheSessionGoesOn) {
  std::promise<void> go_on;
  before_export_ = [waits = go_on.get_future().share()](const ExportRequest&) { waits.wait(); };
  jobs_.post(export_of(kOurs, 1));
  jobs_.post(ProbeRequest{kOurs, 2, scene(7), 0.5, 0.5, 40, 30});
  const auto ready = wait_for<ProbeReady>([](const ProbeReady& of) { return of.request == 2; });
  EXPECT_EQ(ready.revision, 7u);
  EXPECT_TRUE(ready.facts.hit);
  EXPECT_EQ(ready.facts.interval, 1u);
  jobs_.post(ProbeRequest{kOurs, 3, scene(7), -0.5, 0.5, 40, 30});
  EXPECT_EQ(failure_of(3).code, ErrorCode::invalid_argument);
  go_on.set_value();
  wait_for<ExportReady>([](const ExportReady& of) { return of.request == 1; });
}

TEST_F(JobsTest, ALineIsReadAndWhatHasOneStepIsNotFollowedOverTime) {
  jobs_.post(CurveRequest{kOurs, 1, scene(7), "", {-2, 0, 0}, Vec3d{2, 0, 0}});
  const auto ready = wait_for<CurveReady>([](const CurveReady& of) { return of.request == 1; });
  EXPECT_EQ(ready.revision, 7u);
  EXPECT_EQ(ready.facts.array, "distance");
  EXPECT_GT(ready.facts.at.size(), 10u);
  EXPECT_FALSE(ready.facts.layers.empty());
  jobs_.post(CurveRequest{kOurs, 2, scene(7), "", {0.6, 0, 0}, std::nullopt});
  EXPECT_EQ(failure_of(2).code, ErrorCode::invalid_argument);
  jobs_.post(CurveRequest{kOurs, 3, scene(7), "none", {-2, 0, 0}, Vec3d{2, 0, 0}});
  EXPECT_EQ(failure_of(3).code, ErrorCode::not_found);
}

TEST_F(JobsTest, QuestionsOfOneSessionWaitForEachOtherAndThoseOfAnotherDoNot) {
  std::promise<void> go_on;
  before_export_ = [waits = go_on.get_future().share()](const ExportRequest& of) {
    if (of.request == 1) waits.wait();
  };
  jobs_.post(export_of(kOurs, 1));
  jobs_.post(export_of(kOurs, 2));
  jobs_.post(ExportRequest{kTheirs, 3, scene(1), folder_.path() / "theirs.vtu", {}});
  wait_for<ExportReady>([](const ExportReady& of) { return of.request == 3; });
  operations_.cancel({.session = kOurs, .request = 2});
  {
    const std::lock_guard lock(mutex_);
    for (const EngineEvent& event : events_) EXPECT_FALSE(request_of(event) == 2 || std::holds_alternative<RequestFailed>(event));
  }
  go_on.set_value();
  EXPECT_EQ(failure_of(2).code, ErrorCode::cancelled);
  wait_for<ExportReady>([](const ExportReady& of) { return of.request == 1; });
}

/// A reader is as nice as the thread that asks for it (LoadedImporter.AReaderIsAsNice...), which is the one that answers.
TEST_F(JobsTest, WhoReadsAFileYieldsToWhoDraws) {
  const int here = getpriority(PRIO_PROCESS, 0);
  if (here >= 10) GTEST_SKIP() << "these tests are as nice themselves";
  std::promise<int> nice;
  Jobs jobs({std::uint64_t{1} << 30}, datasets_, operations_, memory(), [&](const EngineEvent& event) {
    if (std::holds_alternative<DatasetReady>(event)) nice.set_value(getpriority(PRIO_PROCESS, 0));
  });
  jobs.post(OpenRequest{kOurs, 1, "torus-12"});
  EXPECT_GT(nice.get_future().get(), here);
}

TEST_F(JobsTest, ASmallPictureIsNotGivenRoomThatSomebodyWouldHaveToMake) {
  jobs_.post(ThumbnailRequest{0, 1, "torus-12"});
  EXPECT_EQ(failure_of(1).code, ErrorCode::unavailable);
  EXPECT_TRUE(loans_.empty());
}

TEST_F(JobsTest, NothingIsAnsweredOnceAllOperationsAreEnded) {
  operations_.cancel_all();
  jobs_.post(export_of(kOurs, 1));
  jobs_.post(OpenRequest{kOurs, 2, "torus-12"});
  jobs_.post(OpenRequest{kOurs, 3, "torus-12", true});
  jobs_.post(MeasureRequest{kOurs, 4, scene(1)}, as_mesh());
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const std::lock_guard lock(mutex_);
  EXPECT_TRUE(events_.empty());
}

}  // namespace
}  // namespace isostrata
