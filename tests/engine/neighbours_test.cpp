// What one session asks for and what another one waits: the order of what happens, never how long it takes. Without turns each of
// the heavy works here is done before anybody else's next picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "data/dataset/dataset_bytes.h"
#include "data/open/import_door.h"
#include "engine/engine/engine.h"
#include "engine/heard_events.h"
#include "engine/picture/export_mesh.h"
#include "engine/picture/extract_scene.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

constexpr SessionKey kHeavy = 1, kPolite = 2;

class Neighbours : public ::testing::Test, protected HeardEvents {
 protected:
  Neighbours() {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:12", "torus:32", "cylinder:64x64x32x4"});
    options.renderer_choice = {"native", "native"};
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
    engine_->post(SceneUpdate{kPolite, scene(1)});
    engine_->post(frame(kPolite, 1000));
    frame_of(1000);
  }
  ~Neighbours() override { engine_.reset(); }

  /// Many layers whose colours run: the most that a scene may ask of a renderer.
  static Scene heavy_scene(std::uint64_t revision = 1) {
    Scene heavy = scene(revision, 0.5, "torus-32");
    heavy.intervals.clear();
    for (std::uint32_t i = 0; i < 256; ++i) {
      SceneInterval layer{i + 1, 0.7 * i / 256, 0.7 * (i + 1) / 256, {1, 0, 0}, "", 0.02, 0, true};
      layer.color_map = "viridis";
      heavy.intervals.push_back(layer);
    }
    return heavy;
  }
  static FrameRequest still(RequestId request, int side) {
    FrameRequest wanted = frame(kHeavy, request, true);
    wanted.width = wanted.height = side;
    wanted.still = StillFormat::png;
    return wanted;
  }
  void wait_until_drawn(RequestId request) {
    wait_for<FrameStarted>([=](const FrameStarted& f) { return f.request == request; });
  }
  /// A camera that turns, each picture awaited.
  void drag(int frames) {
    for (int i = 0; i < frames; ++i) {
      Scene turned = scene(++revision_);
      turned.camera->eye.x = 3 + 0.01 * i;
      engine_->post(SceneUpdate{kPolite, turned});
      engine_->post(frame(kPolite, ++request_));
      EXPECT_EQ(frame_of(request_).revision, revision_);
    }
  }
  /// Whether the request has been answered by now.
  bool answered(RequestId request) {
    std::lock_guard lock(mutex_);
    return std::any_of(events_.begin(), events_.end(), [&](const EngineEvent& event) {
      return !std::holds_alternative<FrameStarted>(event) && !std::holds_alternative<OperationProgress>(event) &&
             !std::holds_alternative<OperationDone>(event) && request_of(event) == request;
    });
  }

  std::unique_ptr<Engine> engine_;
  std::uint64_t revision_ = 1;
  RequestId request_ = 2000;
};

TEST_F(Neighbours, FramesAreDrawnBesideAHugeStill) {
  engine_->post(SceneUpdate{kHeavy, scene(1, 0.5, "torus-32")});
  engine_->post(still(1, 8192));
  wait_until_drawn(1);
  drag(20);
  EXPECT_FALSE(answered(1)) << "the still came first";
  EXPECT_EQ(frame_of(1).width, 8192);
}

TEST_F(Neighbours, FramesAreDrawnBesideAStillOf256MappedLayersAndItsSessionCanEnd) {
  engine_->post(SceneUpdate{kHeavy, heavy_scene()});
  engine_->post(still(1, 2048));
  wait_until_drawn(1);
  drag(20);
  EXPECT_FALSE(answered(1)) << "the still came first";
  engine_->post(CloseSession{kHeavy});
  EXPECT_EQ(failure_of(1).code, ErrorCode::cancelled);
  drag(3);
}

TEST_F(Neighbours, FramesAreDrawnBesideAFrameThatIsFarHeavier) {
  engine_->post(SceneUpdate{kHeavy, heavy_scene()});
  FrameRequest wanted = frame(kHeavy, 1);
  wanted.width = wanted.height = 2048;
  engine_->post(wanted);
  wait_until_drawn(1);
  drag(20);
  EXPECT_FALSE(answered(1)) << "the heavy frame came first";
  engine_->post(ForgetFrame{kHeavy, 1});
  EXPECT_EQ(failure_of(1).code, ErrorCode::cancelled);
}

TEST_F(Neighbours, FramesAreDrawnBesideSpaceTime) {
  Scene heavy = scene(1, 0.6, "cylinder-64x64x32x4");
  heavy.array = "";
  heavy.intervals = {{1, 0.9, 1.1, {1, 0, 0}, "", 0.5, 0, true}};
  heavy.time = 0.5;
  heavy.time_mode = TimeMode::spacetime;
  engine_->post(SceneUpdate{kHeavy, heavy});
  engine_->post(frame(kHeavy, 1));
  drag(20);
  EXPECT_FALSE(answered(1)) << "the slice of space-time came first";
  engine_->post(CloseSession{kHeavy});
}

TEST_F(Neighbours, AStillThatNobodyWantsEndsAndTheNextOneIsDrawn) {
  engine_->post(SceneUpdate{kHeavy, heavy_scene()});
  engine_->post(still(1, 2048));
  engine_->post(still(2, 16));
  wait_until_drawn(1);
  engine_->post(ForgetFrame{kHeavy, 1});
  EXPECT_EQ(frame_of(2).width, 16);
  EXPECT_EQ(failure_of(1).code, ErrorCode::cancelled);
}

TEST_F(Neighbours, ASessionsFramesAreDrawnBesideItsStill) {
  engine_->post(SceneUpdate{kPolite, heavy_scene(++revision_)});
  FrameRequest wanted = still(1, 2048);
  wanted.session = kPolite;
  engine_->post(wanted);
  wait_until_drawn(1);
  engine_->post(frame(kPolite, 2));
  frame_of(2);
  EXPECT_FALSE(answered(1));
  engine_->post(ForgetFrame{kPolite, 1});
}

TEST_F(Neighbours, ANewerSceneEndsAFrameAtRestInTheMiddle) {
  std::uint64_t revision = 0;
  RequestId request = 0;
  engine_->post(SceneUpdate{kHeavy, heavy_scene(++revision)});
  for (const bool lossless : {true, false}) {
    FrameRequest wanted = frame(kHeavy, ++request, lossless);
    wanted.width = wanted.height = 2048;
    if (lossless) wanted.band_bytes = 64 << 10;
    wanted.until_newer = true;
    engine_->post(wanted);
    wait_until_drawn(request);
    Scene turned = heavy_scene(++revision);
    turned.camera->eye.x += 1;
    engine_->post(SceneUpdate{kHeavy, turned});
    EXPECT_EQ(failure_of(request).code, ErrorCode::cancelled);
    engine_->post(frame(kHeavy, ++request));
    EXPECT_EQ(frame_of(request).revision, revision);
  }
}

TEST_F(Neighbours, ManySessionsDrawAtOnceAndEachGetsItsOwn) {
  constexpr int kSessions = 12, kFrames = 10;
  RequestId request = 5000;
  for (int f = 0; f < kFrames; ++f)
    for (SessionKey s = 10; s < 10 + kSessions; ++s) {
      engine_->post(SceneUpdate{s, scene(static_cast<std::uint64_t>(f + 1), 0.3 + 0.01 * static_cast<double>(s))});
      FrameRequest wanted = frame(s, ++request, f + 1 == kFrames);
      wanted.jpeg = true;
      if (f % 3 == 2) wanted.still = StillFormat::png, wanted.lossless = true;
      engine_->post(wanted);
    }
  for (SessionKey s = 10; s < 10 + kSessions; ++s) {
    const FrameReady last = frame_of(5000 + static_cast<RequestId>((kFrames - 1) * kSessions) + (s - 9));
    EXPECT_EQ(last.session, s);
    EXPECT_EQ(last.revision, static_cast<std::uint64_t>(kFrames));
  }
  for (RequestId r = 5001; r <= request; ++r) EXPECT_EQ(frame_of(r).session, 10 + (r - 5001) % kSessions);
}

TEST_F(Neighbours, TheEngineEndsInTheMiddleOfAllThis) {
  for (SessionKey s = 20; s < 24; ++s) {
    engine_->post(SceneUpdate{s, heavy_scene()});
    FrameRequest wanted = still(s, 4096);
    wanted.session = s;
    engine_->post(wanted);
    FrameRequest moving = frame(s, 100 + s);
    moving.width = moving.height = 1024;
    engine_->post(moving);
  }
  wait_until_drawn(20);
  engine_.reset();
}

class TightMemory : public ::testing::Test, protected HeardEvents {
 protected:
  /// With --max-memory of so many.
  void begin(std::uint64_t max_bytes) {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:32", "torus:96"});
    options.renderer_choice = {"native", "native"};
    options.store.max_bytes = max_bytes;
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  /// As the engine holds it.
  static std::uint64_t bytes_of(const std::shared_ptr<const Dataset>& data, const Scene& scene) {
    SceneAids aids;
    aids.facets_alone = true;
    return scene_bytes(*extract_scene([&](int, const Task&) { return data; }, scene, nullptr, Task{}, aids));
  }
  static Scene of_session(SessionKey session) { return scene(1, 0.4 + 0.01 * static_cast<double>(session), "torus-32"); }
  Bytes picture(SessionKey session, RequestId request, double* extract_ms = nullptr) {
    engine_->post(frame(session, request, true));
    const FrameReady ready = frame_of(request);
    if (extract_ms) *extract_ms = ready.stages.extract_ms;
    return ready.bytes ? *ready.bytes : Bytes{};
  }
  std::unique_ptr<Engine> engine_;
};

TEST_F(TightMemory, ScenesThatNobodyLooksAtAreGivenBackAndMadeAgain) {
  constexpr SessionKey kSessions = 8;
  const std::shared_ptr<const Dataset> data = open_dataset("torus:32", {}, Task{});
  const std::uint64_t one = bytes_of(data, of_session(kSessions));
  begin(dataset_bytes(*data) + 4 * one);
  std::vector<Bytes> first;
  RequestId request = 0;
  for (SessionKey s = 1; s <= kSessions; ++s) {
    engine_->post(SceneUpdate{s, of_session(s)});
    first.push_back(picture(s, ++request));
  }
  int made_again = 0;
  for (int round = 0; round < 2; ++round)
    for (SessionKey s = 1; s <= kSessions; ++s) {
      double extract_ms = 0;
      EXPECT_EQ(picture(s, ++request, &extract_ms), first[s - 1]) << "session " << s;
      made_again += extract_ms > 0;
    }
  EXPECT_GT(made_again, 0);
  engine_.reset();
}

TEST_F(TightMemory, ScenesThatAreMadeAtOnceAndThatNobodyHasSeenMakeWay) {
  constexpr SessionKey kSessions = 10;
  const std::shared_ptr<const Dataset> data = open_dataset("torus:32", {}, Task{});
  const std::uint64_t one = bytes_of(data, of_session(kSessions));
  begin(dataset_bytes(*data) + one + one / 2);
  for (SessionKey s = 1; s <= kSessions; ++s) engine_->post(SceneUpdate{s, of_session(s)});
  for (SessionKey s = 1; s <= kSessions; ++s) EXPECT_FALSE(picture(s, s).empty()) << "session " << s;
  for (const EngineEvent& event : events_) EXPECT_FALSE(std::holds_alternative<RequestFailed>(event));
  engine_.reset();
}

// 10 bytes a pixel: one of these fits and two do not.
TEST_F(TightMemory, LargeStillsWaitForEachOtherAndNoFrameWaitsForThem) {
  begin(180'000'000);
  constexpr SessionKey kSessions = 3;
  for (SessionKey s = 1; s <= kSessions; ++s) {
    engine_->post(SceneUpdate{s, of_session(s)});
    picture(s, 100 + s);
  }
  for (SessionKey s = 1; s <= kSessions; ++s) {
    FrameRequest wanted = frame(s, s, true);
    wanted.width = wanted.height = 3200;
    wanted.still = StillFormat::png;
    engine_->post(wanted);
    picture(s, 200 + s);
  }
  for (SessionKey s = 1; s <= kSessions; ++s) EXPECT_EQ(frame_of(s).width, 3200);
  int at_once = 0, most = 0;
  for (const EngineEvent& event : events_) {
    if (const auto* started = std::get_if<FrameStarted>(&event); started && started->request <= kSessions) most = std::max(most, ++at_once);
    if (const auto* ready = std::get_if<FrameReady>(&event); ready && ready->request <= kSessions) --at_once;
  }
  EXPECT_EQ(most, 1);
  engine_.reset();
}

TEST_F(TightMemory, AStillThatNeverFitsIsRefusedWithTheNumbers) {
  begin(130'000'000);
  engine_->post(SceneUpdate{1, of_session(1)});
  FrameRequest wanted = frame(1, 1, true);
  wanted.width = wanted.height = 4096;
  wanted.still = StillFormat::png;
  engine_->post(wanted);
  const RequestFailed failed = failure_of(1);
  EXPECT_EQ(failed.code, ErrorCode::too_large);
  EXPECT_NE(failed.message.find("a picture of 4096x4096 needs about 167 MB; "), std::string::npos) << failed.message;
  EXPECT_NE(failed.message.find(" of the 130 MB that this server may take are free"), std::string::npos) << failed.message;
  engine_.reset();
}

TEST_F(TightMemory, AnExportIsHeldToWhatIsFree) {
  const testing::TemporaryFolder folder;
  RequestId request = 0;
  const auto export_with = [&](std::uint64_t max_bytes, const Scene& of) {
    begin(max_bytes);
    engine_->post(ExportRequest{1, ++request, of, (folder / (std::to_string(request) + ".vtu")).string(), {}});
  };
  export_with(200'000'000, of_session(1));
  EXPECT_GT(wait_for<ExportReady>([&](const ExportReady& e) { return e.request == request; }).mesh.tetrahedra, 0);
  export_with(20'000'000, of_session(1));
  EXPECT_NE(failure_of(request).message.find("this export needs about 33 MB; "), std::string::npos) << failure_of(request).message;
  Scene large = of_session(1);
  large.dataset = "torus-96";
  export_with(100'000'000, large);
  EXPECT_EQ(failure_of(request).code, ErrorCode::too_large);
  EXPECT_NE(failure_of(request).message.find("bytes; the limit is"), std::string::npos) << failure_of(request).message;
  engine_.reset();
}

TEST(ExportRoom, FilesOfExportsTakeSoMuchOfTheDiskAndNoMore) {
  const testing::TemporaryFolder folder;
  const std::shared_ptr<const Dataset> data = open_dataset("torus:32", {}, Task{});
  const StepSource steps = [&](int, const Task&) { return data; };
  Scene scene;
  scene.array = "distance";
  scene.intervals.push_back({1, 0.0, 0.7, {1, 0, 0}, "", 0.5, 0, true});
  const auto refusal = [&](std::uint64_t exports) -> std::string {
    try {
      export_mesh(steps, scene, folder / "a.vtu", {.compression = 0}, {.exports = exports}, Task{});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::too_large);
      return error.what();
    }
    return {};
  };
  EXPECT_NE(refusal(4'000'000).find("would be larger than 2000000 bytes"), std::string::npos) << refusal(4'000'000);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "nothing is left of it";
  EXPECT_EQ(refusal(1'000'000'000), "");
  const auto bytes = std::filesystem::file_size(folder / "a.vtu");
  EXPECT_NE(refusal(bytes + 1'000'000).find("exports take " + std::to_string(bytes / 1'000'000) + " MB of the "), std::string::npos) << refusal(bytes + 1'000'000);
}

TEST_F(TightMemory, ASceneThatDoesNotFitIsRefusedWithTheNumbers) {
  begin(400'000);
  engine_->post(SceneUpdate{1, of_session(1)});
  engine_->post(frame(1, 1));
  const RequestFailed failed = failure_of(1);
  EXPECT_EQ(failed.code, ErrorCode::too_large);
  EXPECT_NE(failed.message.find("bytes; the limit is"), std::string::npos) << failed.message;
  engine_.reset();
}

}  // namespace
}  // namespace isostrata
