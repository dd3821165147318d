#include "worker/worker_engine.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <set>
#include <thread>

#include "engine/heard_events.h"
#include "support/places.h"
#include "support/plain_renderer.h"
#include "support/temporary_folder.h"
#include "worker/message_channel.h"

namespace isostrata {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

std::size_t open_descriptors() {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}
/// Living and dead children of this process.
std::set<pid_t> children() {
  std::set<pid_t> all;
  for (const auto& thread : fs::directory_iterator("/proc/self/task")) {
    std::ifstream file(thread.path() / "children");
    for (pid_t pid; file >> pid;) all.insert(pid);
  }
  return all;
}

/// A worker of a process of its own that draws plain colours, and everything it has said.
class WorkerEngineTest : public ::testing::Test, protected HeardEvents {
 protected:
  void start(WorkerOptions worker = {}, RendererChoice choice = {}) {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:12", "torus:24", "torus:160"});
    options.renderer_choice = choice;
    if (worker.plan.program.empty()) {
      worker.plan.program = isostrata::places::binaries() + "/isostrata-faulty-worker";
      worker.plan.arguments = {};
    }
    engine_ = std::make_unique<WorkerEngine>(std::move(options), std::move(worker),
                                             [this](EngineEvent event) { note(std::move(event)); });
  }
  ~WorkerEngineTest() override { engine_.reset(); }

  template <class Event>
  int count(const std::function<bool(const Event&)>& fits) {
    std::lock_guard lock(mutex_);
    int n = 0;
    for (const EngineEvent& event : events_)
      if (const auto* e = std::get_if<Event>(&event); e && fits(*e)) ++n;
    return n;
  }
  /// The process of the worker that is ready.
  pid_t worker() {
    for (int i = 0; i < 6000; ++i) {
      if (const pid_t process = engine_->facts().process) return process;
      std::this_thread::sleep_for(10ms);
    }
    ADD_FAILURE() << "no worker comes";
    return 0;
  }
  /// Never to process 0, which would be this one and all around it.
  void signal_worker(int signal) {
    if (const pid_t process = worker(); process > 0) kill(process, signal);
  }
  void kill_worker(int signal = SIGKILL) {
    const std::uint64_t before = engine_->facts().deaths;
    signal_worker(signal);
    if (signal == SIGKILL)
      for (int i = 0; i < 6000 && engine_->facts().deaths == before; ++i) std::this_thread::sleep_for(10ms);
  }

  std::unique_ptr<WorkerEngine> engine_;
};

TEST_F(WorkerEngineTest, DrawsWhatAnEngineInThisProcessDraws) {
  start();
  EXPECT_NE(worker(), getpid());
  EXPECT_EQ(engine_->device(), "plain");
  engine_->post(OpenRequest{1, 1, "torus-12"});
  const DatasetReady ready = wait_for<DatasetReady>([](const auto& r) { return r.request == 1; });
  engine_->post(SceneUpdate{1, scene(7)});
  engine_->post(frame(1, 2, true));
  const FrameReady theirs = frame_of(2);
  engine_->post(HistogramRequest{1, 3, "torus-12", 0, "distance", 16});
  EXPECT_EQ(wait_for<HistogramReady>([](const auto& r) { return r.request == 3; }).counts.size(), 16u);
  engine_->post(OpenRequest{1, 4, "/etc/passwd"});
  EXPECT_EQ(failure_of(4).code, ErrorCode::not_found);

  EngineOptions options;
  options.catalogue = Catalogue::from_sources({"torus:12"});
  options.renderer = [] { return std::make_unique<PlainRenderer>(std::make_shared<PlainRendererControl>()); };
  Engine here(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  here.post(OpenRequest{1, 101, "torus-12"});
  EXPECT_EQ(wait_for<DatasetReady>([](const auto& r) { return r.request == 101; }).facts.first_view, ready.facts.first_view);
  here.post(SceneUpdate{1, scene(7)});
  here.post(frame(1, 102, true));
  const FrameReady ours = frame_of(102);
  EXPECT_EQ(*theirs.bytes, *ours.bytes);
  EXPECT_EQ(theirs.revision, ours.revision);
  EXPECT_EQ(theirs.camera, ours.camera);
  EXPECT_EQ(theirs.tetrahedra, ours.tetrahedra);
  ASSERT_EQ(theirs.intervals.size(), 1u);
  EXPECT_EQ(theirs.intervals[0].volume, ours.intervals[0].volume);
  EXPECT_EQ(theirs.device, ours.device);
}

TEST_F(WorkerEngineTest, AKilledWorkerIsReplacedAndWhatWasAskedIsAnsweredOnce) {
  start();
  Scene slow = scene(1);
  slow.unit_distance = 15;
  engine_->post(SceneUpdate{1, slow});
  engine_->post(SceneUpdate{2, scene(5, 0.4)});
  for (RequestId request = 1; request <= 4; ++request) engine_->post(frame(1, request));
  engine_->post(OpenRequest{2, 5, "torus-24"});
  wait_for<FrameStarted>([](const auto&) { return true; });
  kill_worker();
  for (RequestId request = 1; request <= 4; ++request) EXPECT_EQ(frame_of(request).revision, 1u);
  wait_for<DatasetReady>([](const auto& r) { return r.request == 5; });
  engine_->post(frame(2, 6));
  EXPECT_EQ(frame_of(6).revision, 5u) << "the other session's scene was told, too";
  for (RequestId request = 1; request <= 6; ++request) {
    EXPECT_LE(count<FrameStarted>([=](const auto& e) { return e.request == request; }), 1);
    EXPECT_LE(count<FrameReady>([=](const auto& e) { return e.request == request; }), 1);
    EXPECT_EQ(count<RequestFailed>([=](const auto& e) { return e.request == request; }), 0);
  }
  const EngineFacts facts = engine_->facts();
  EXPECT_EQ(facts.deaths, 1u);
  EXPECT_EQ(facts.processes, 2u);
  EXPECT_TRUE(facts.fallback.empty());
  EXPECT_NE(facts.last_death.find("signal 9"), std::string::npos) << facts.last_death;
  EXPECT_NE(facts.last_death.find("drawing"), std::string::npos) << facts.last_death;
  const auto said = wait_for<OperationProgress>([](const auto& p) { return p.stage.find("signal 9") != std::string::npos; });
  wait_for<OperationDone>([&](const auto& d) { return d.operation == said.operation; });
}

TEST_F(WorkerEngineTest, ADragGoesOnOverADeath) {
  start();
  RequestId request = 0;
  std::uint64_t shown = 0;
  for (std::uint64_t revision = 1; revision <= 60; ++revision) {
    engine_->post(SceneUpdate{1, scene(revision, 0.4 + 0.01 * static_cast<double>(revision))});
    if (revision == 20) signal_worker(SIGKILL);
    if (revision % 10 != 0) continue;
    engine_->post(frame(1, ++request));
    const auto ready = frame_of(request);
    EXPECT_GE(ready.revision, shown);
    EXPECT_LE(ready.revision, revision);
    shown = ready.revision;
  }
  engine_->post(frame(1, ++request, true));
  EXPECT_EQ(frame_of(request).revision, 60u);
  EXPECT_EQ(engine_->facts().deaths, 1u);
}

TEST_F(WorkerEngineTest, AWorkerThatStandsStillIsSaidToAndReplaced) {
  WorkerOptions options;
  options.plan.program = isostrata::places::binaries() + "/isostrata-faulty-worker";
  options.plan.arguments = {};
  options.soft_limit = 800ms;
  options.hard_limit = 3000ms;
  start(options);
  engine_->post(SceneUpdate{1, scene(3)});
  engine_->post(frame(1, 1));
  frame_of(1);
  const pid_t stopped = worker();
  kill_worker(SIGSTOP);
  engine_->post(frame(1, 2));
  // However much is asked meanwhile, it waits in one place for each session.
  for (std::uint64_t revision = 4; revision < 4000; ++revision) {
    engine_->post(SceneUpdate{1, scene(revision)});
    engine_->post(frame(1, revision + 1000));
    engine_->post(ForgetFrame{1, revision + 1000});
  }
  const auto said =
      wait_for<OperationProgress>([](const auto& p) { return p.stage.find("no sign of life") != std::string::npos; });
  EXPECT_EQ(said.session, 1u);
  EXPECT_EQ(frame_of(2).revision, 3999u);
  EXPECT_NE(kill(stopped, 0), 0) << "it is gone, and was waited for";
  EXPECT_NE(engine_->facts().last_death.find("watchdog"), std::string::npos) << engine_->facts().last_death;
}

TEST_F(WorkerEngineTest, ADrawingThatHangsCanBeGivenUpByItsViewer) {
  WorkerOptions options;
  options.plan.program = isostrata::places::binaries() + "/isostrata-faulty-worker";
  options.plan.arguments = {};
  options.soft_limit = 500ms;
  options.hard_limit = 600000ms;
  start(options);
  Scene hangs = scene(1);
  hangs.unit_distance = 14;
  engine_->post(SceneUpdate{1, hangs});
  engine_->post(frame(1, 1));
  const auto said =
      wait_for<OperationProgress>([](const auto& p) { return p.stage.find("no sign of life") != std::string::npos; });
  engine_->post(SceneUpdate{1, scene(2)});
  engine_->post(CancelRequest{1, said.operation, 0});
  EXPECT_EQ(frame_of(1).revision, 2u);
  EXPECT_NE(engine_->facts().last_death.find("given up"), std::string::npos) << engine_->facts().last_death;
}

TEST_F(WorkerEngineTest, ThreeDeathsInAMinuteFallBackToNativeAndNameTheCause) {
  start();
  engine_->post(SceneUpdate{1, scene(1)});
  for (int i = 0; i < 3; ++i) kill_worker(SIGKILL);
  engine_->post(frame(1, 1));
  const std::string device = frame_of(1).device;
  EXPECT_NE(device.find("in place of plain"), std::string::npos) << device;
  EXPECT_NE(device.find("3 times in 60 s"), std::string::npos) << device;
  EXPECT_NE(device.find("signal 9"), std::string::npos) << device;
  EXPECT_EQ(engine_->device(), device);
  EXPECT_FALSE(engine_->facts().fallback.empty());
}

TEST_F(WorkerEngineTest, ADeviceThatWasGivenUpIsTriedAgainWithGrowingPauses) {
  WorkerOptions options;
  options.plan.program = isostrata::places::binaries() + "/isostrata-faulty-worker";
  options.plan.arguments = {};
  options.retry_pause = 6s;
  start(options);
  engine_->post(SceneUpdate{1, scene(1)});
  for (int i = 0; i < 3; ++i) kill_worker(SIGKILL);
  engine_->post(frame(1, 1));
  const std::string device = frame_of(1).device;
  EXPECT_NE(device.find("tried again in 6 s"), std::string::npos) << device;
  const auto until = [&](bool fallen_back) {
    for (int i = 0; i < 6000 && engine_->facts().fallback.empty() == fallen_back; ++i) std::this_thread::sleep_for(10ms);
    return engine_->facts().fallback.empty() != fallen_back;
  };
  ASSERT_TRUE(until(false));
  engine_->post(frame(1, 2));
  EXPECT_EQ(frame_of(2).device, "plain");
  kill_worker(SIGKILL);
  ASSERT_TRUE(until(true)) << "on trial one death is enough";
  engine_->post(frame(1, 3));
  const std::string again = frame_of(3).device;
  EXPECT_NE(again.find("in place of plain, whose process died again"), std::string::npos) << again;
  EXPECT_NE(again.find("tried again in 12 s"), std::string::npos) << again;
  EXPECT_TRUE(engine_->facts().trouble.empty());
}

TEST_F(WorkerEngineTest, ASceneThatKillsEveryWorkerIsRefusedAndTheOthersGoOn) {
  start({}, {"native", "native"});
  Scene deadly = scene(1);
  deadly.unit_distance = 13;
  engine_->post(SceneUpdate{1, deadly});
  engine_->post(SceneUpdate{2, scene(1)});
  engine_->post(frame(1, 1));
  const RequestFailed failed = failure_of(1);
  EXPECT_EQ(failed.code, ErrorCode::unavailable);
  EXPECT_NE(failed.message.find("signal 6"), std::string::npos) << failed.message;
  engine_->post(frame(2, 2));
  EXPECT_EQ(frame_of(2).revision, 1u);
  engine_->post(SceneUpdate{1, scene(2)});
  engine_->post(frame(1, 3));
  EXPECT_EQ(frame_of(3).revision, 2u) << "a scene that changed gets another chance";
  EXPECT_EQ(engine_->facts().deaths, 3u);
}

TEST_F(WorkerEngineTest, NothingIsLeftBehind) {
  const std::size_t descriptors = open_descriptors();
  const testing::OwnTemporaryPlace temporary;
  start();
  engine_->post(SceneUpdate{1, scene(1)});
  engine_->post(frame(1, 1));
  frame_of(1);
  const std::size_t with_one = open_descriptors();
  EXPECT_FALSE(fs::is_empty(temporary.path()));
  std::set<pid_t> dead;
  for (int i = 0; i < 2; ++i) {
    dead.insert(worker());
    kill_worker();
    engine_->post(frame(1, 10 + static_cast<RequestId>(i)));
    frame_of(10 + static_cast<RequestId>(i));
  }
  EXPECT_EQ(open_descriptors(), with_one);
  const pid_t last = worker();
  EXPECT_EQ(children(), std::set<pid_t>{last}) << "no zombies";
  engine_.reset();
  EXPECT_EQ(children(), std::set<pid_t>{});
  EXPECT_EQ(open_descriptors(), descriptors);
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST_F(WorkerEngineTest, LargePicturesPass) {
  start();
  engine_->post(SceneUpdate{1, scene(1)});
  FrameRequest large = frame(1, 1);
  large.width = 5000;
  large.height = 4000;
  large.jpeg_quality = 100;
  engine_->post(large);
  EXPECT_GT(frame_of(1).bytes->size(), MessageChannel::kMaxInline) << "it goes by memory file";
}

TEST_F(WorkerEngineTest, ADatasetThatIsBeingReadCanBeCancelledWhileTheWorkerIsReplaced) {
  start();
  engine_->post(OpenRequest{1, 1, "torus-160"});
  signal_worker(SIGKILL);
  engine_->post(CancelRequest{1, 0, 1});
  // Whichever was first: it is answered once.
  std::unique_lock lock(mutex_);
  EXPECT_TRUE(changed_.wait_for(lock, 60s, [&] {
    return std::any_of(events_.begin(), events_.end(), [](const EngineEvent& event) {
      const auto* failed = std::get_if<RequestFailed>(&event);
      const auto* ready = std::get_if<DatasetReady>(&event);
      return (failed && failed->request == 1 && failed->code == ErrorCode::cancelled) || (ready && ready->request == 1);
    });
  }));
}

TEST_F(WorkerEngineTest, WhatCannotStartIsSaid) {
  WorkerOptions absent;
  absent.plan.program = "/no/such/program";
  EXPECT_THROW(start(absent), Error);
  try {
    WorkerOptions ends;
    ends.plan.program = "/bin/false";
    start(ends);
    FAIL() << "a program that only ends is not a worker";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unavailable);
    EXPECT_NE(std::string(error.what()).find("status 1"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace isostrata
