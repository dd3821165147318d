// The first picture of a large grid: of every n-th point, until the layers of all points are there.
#include "engine/picture/coarse_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "data/dataset/analytic.h"
#include "engine/engine/engine.h"
#include "engine/heard_events.h"
#include "engine/messages/coarse_levels.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/interval_facts.h"
#include "rendering/choice/native_renderer.h"
#include "support/plain_renderer.h"

namespace isostrata {
namespace {

using Stride = std::array<std::int64_t, 3>;

constexpr std::int64_t kMost = std::int64_t{1} << 24;

Grid boxes(std::int64_t x, std::int64_t y, std::int64_t z) { return {UniformGrid{{x, y, z}, {0, 0, 0}, {1, 1, 1}}, {}, {}}; }

TEST(CoarseStride, IsTheLeastThatLeavesFewPointsAndNoAxisThin) {
  constexpr std::int64_t kLeast = std::int64_t{1} << 26;
  EXPECT_EQ(coarse_stride(boxes(400, 400, 400), kLeast, kMost), (Stride{1, 1, 1})) << "its own picture is there as soon";
  EXPECT_EQ(coarse_stride(boxes(512, 512, 512), kLeast, kMost), (Stride{2, 2, 2}));
  EXPECT_EQ(coarse_stride(boxes(1024, 1024, 1024), kLeast, kMost), (Stride{4, 4, 4}));
  EXPECT_EQ(coarse_stride(boxes(2048, 2048, 2048), kLeast, kMost), (Stride{8, 8, 8}));
  const Stride flat = coarse_stride(boxes(20000, 20000, 2), kLeast, kMost);
  EXPECT_EQ(flat[2], 1);
  EXPECT_GT(flat[0], 1);
  EXPECT_LE((20000 / flat[0]) * (20000 / flat[1]) * 2, std::int64_t{1} << 24);
  EXPECT_EQ(coarse_stride(make_analytic("tets:20", {}, Task{})->grid, 10, kMost), (Stride{1, 1, 1})) << "of structured grids only";
}

Scene torus_scene() {
  Scene scene;
  scene.intervals.push_back({1, 0.1, 0.4, {1, 0, 0}, "", 0.5, 0, true});
  scene.intervals.push_back({2, 0.6, 0.7, {0, 1, 0}, "", 0.5, 0, true});
  return scene;
}

TEST(CoarseStride, EachLevelOfWhatMovesHasFewerPointsAndNoAxisHasFew) {
  const auto points = [](const Grid& grid, const Stride& stride) {
    std::int64_t n = 1;
    for (std::size_t a = 0; a < 3; ++a) n *= (grid.dims()[a] - 1) / stride[a] + 1;
    return n;
  };
  for (const Grid& grid : {boxes(256, 256, 256), boxes(1024, 512, 300), boxes(400, 400, 100)}) {
    std::int64_t before = grid.point_count();
    for (int level = 1; level <= kCoarseLevels; ++level) {
      const Stride stride = moving_stride(grid, level);
      EXPECT_LT(points(grid, stride), before) << "level " << level;
      before = points(grid, stride);
      for (std::size_t a = 0; a < 3; ++a) EXPECT_GE(grid.dims()[a] / stride[a], 16) << "level " << level;
    }
  }
  EXPECT_EQ(moving_stride(boxes(256, 256, 256), 1), (Stride{2, 2, 2}));
  EXPECT_EQ(moving_stride(boxes(256, 256, 256), 2), (Stride{3, 3, 3}));
  EXPECT_EQ(moving_stride(boxes(1024, 1024, 1024), 2), (Stride{11, 11, 11}));
  EXPECT_EQ(moving_stride(boxes(40, 40, 33), 3), (Stride{2, 2, 2})) << "16 points are few enough";
  EXPECT_EQ(moving_stride(boxes(31, 31, 31), 3), (Stride{1, 1, 1})) << "small grids are moved as they are";
}

TEST(CoarseScenes, AreTheScenesOfEveryNthPoint) {
  const auto whole = make_analytic("torus:65", {}, Task{});
  const auto stride = coarse_stride(whole->grid, 1000, kMost);
  ASSERT_EQ(stride, (Stride{2, 2, 2}));
  // The same points, one by one.
  auto plain = std::make_shared<Dataset>(*whole);
  auto values = std::make_shared<std::vector<float>>();
  for (int k = 0; k < 65; k += 2)
    for (int j = 0; j < 65; j += 2)
      for (int i = 0; i < 65; i += 2) values->push_back(static_cast<float>(whole->arrays[0].at(static_cast<std::size_t>(i + 65 * (j + 65 * k)))));
  const auto& of = std::get<UniformGrid>(whole->grid.shape);
  plain->grid.shape = UniformGrid{{33, 33, 33}, of.origin, of.spacing * 2.0};
  plain->arrays.resize(1);
  plain->arrays[0].type = ScalarType::float32;
  plain->arrays[0].values = std::span<const float>(*values);
  plain->arrays[0].storage = values;

  CoarseScenes scenes(1000);
  const StepSource steps = [&](int, const Task&) { return whole; };
  const auto coarse = scenes.extract(steps, torus_scene(), Task{});
  ASSERT_TRUE(coarse);
  EXPECT_EQ(coarse->point_stride, 2);
  const auto expected = extract_scene(plain, torus_scene(), nullptr, Task{});
  ASSERT_GT(expected->mesh->tetrahedra.size(), 1000u);
  EXPECT_TRUE(std::equal(coarse->mesh->positions.begin(), coarse->mesh->positions.end(), expected->mesh->positions.begin(), expected->mesh->positions.end()));
  EXPECT_TRUE(std::equal(coarse->mesh->tetrahedra.begin(), coarse->mesh->tetrahedra.end(), expected->mesh->tetrahedra.begin(), expected->mesh->tetrahedra.end()));
  EXPECT_EQ(coarse->color_lower, whole->arrays[0].lower) << "colours run over the whole's range";
  EXPECT_EQ(coarse->bounds.upper, whole->bounds.upper);
  EXPECT_EQ(scenes.extract(steps, torus_scene(), Task{})->dataset, coarse->dataset) << "made once for as long as it is held";
}

TEST(CoarseScenes, HaveFacetsAloneForARendererThatNeedsNoMore) {
  const auto whole = make_analytic("torus:65", {}, Task{});
  CoarseScenes scenes(1000);
  Scene scene = torus_scene();
  const auto mesh = scenes.extract_for_motion(whole, scene, 1, Task{}), alone = scenes.extract_for_motion(whole, scene, 1, Task{}, true);
  ASSERT_TRUE(mesh && alone);
  EXPECT_TRUE(mesh->request.tetrahedra && !alone->request.tetrahedra);
  EXPECT_GT(mesh->mesh->tetrahedra.size(), 1000u);
  EXPECT_TRUE(alone->mesh->tetrahedra.empty());
  EXPECT_EQ(tetrahedra_of(*alone), tetrahedra_of(*mesh));
  EXPECT_EQ(alone->mesh->facets.size(), mesh->mesh->facets.size());
  EXPECT_LT(scene_bytes(*alone), scene_bytes(*mesh));
  const auto facts = interval_facts(*alone, scene, true, Task{});
  EXPECT_NEAR(facts.at(0).volume, interval_facts(*mesh, scene, false, Task{}).at(0).volume, 1e-6);
  EXPECT_NEAR(facts[0].volume_error.value(), interval_facts(*mesh, scene, true, Task{}).at(0).volume_error.value(), 1e-3 * facts[0].volume);

  const auto renderer = make_native_renderer();
  const auto draw = [&](const ExtractedScene& of) { return std::get<Image>(renderer->draw(draw_input(of, scene, 160, 120)).image).rgba; };
  EXPECT_EQ(draw(*alone), draw(*mesh));
  scene.intervals[0].color_map = "viridis";
  EXPECT_TRUE(scenes.extract_for_motion(whole, scene, 1, Task{}, true)->request.tetrahedra) << "colours that run are drawn in them";
}

/// Of more cells than are moved as they are.
std::shared_ptr<const Dataset> large_mesh() { return make_analytic("tets:45", {}, Task{}); }

TEST(CoarseScenes, SamplesOfAMeshThatWereMadeInAdvanceAreCutAndKeptAsLongAsTheMeshIsThere) {
  auto mesh = large_mesh();
  CoarseScenes scenes(1000);
  const auto samples = [&] { return std::weak_ptr<const Dataset>(scenes.extract_for_motion(mesh, torus_scene(), 1, Task{})->dataset); };
  EXPECT_TRUE(samples().expired()) << "nobody has them";
  scenes.keep_samples(mesh, torus_scene(), Task{});
  const auto kept = samples();
  EXPECT_FALSE(kept.expired());
  EXPECT_EQ(samples().lock(), kept.lock());
  EXPECT_GT(scenes.held_bytes(), 0u);
  mesh.reset();
  EXPECT_EQ(scenes.held_bytes(), 0u);
  EXPECT_TRUE(kept.expired());
}

TEST(CoarseScenes, WhoAsksForWhatIsBeingMadeGetsTheSame) {
  const auto mesh = large_mesh();
  CoarseScenes scenes(1000);
  std::array<std::shared_ptr<const ExtractedScene>, 2> moved;
  std::thread other([&] { moved[0] = scenes.extract_for_motion(mesh, torus_scene(), 1, Task{}); });
  moved[1] = scenes.extract_for_motion(mesh, torus_scene(), 1, Task{});
  other.join();
  EXPECT_EQ(moved[0]->dataset, moved[1]->dataset);
}

TEST(CoarseScenes, AreNotMadeWhereTheWholeIsThereAsSoonOrSeveralStepsAreShown) {
  const auto whole = make_analytic("torus:20", {}, Task{});
  const StepSource steps = [&](int, const Task&) { return whole; };
  EXPECT_FALSE(CoarseScenes(1 << 20).extract(steps, torus_scene(), Task{}));
  CoarseScenes scenes(1000);
  Scene smear = torus_scene();
  smear.mode = SceneMode::smear;
  EXPECT_FALSE(scenes.extract(steps, smear, Task{}));
  Scene between = torus_scene();
  between.time = 0;
  EXPECT_FALSE(scenes.extract(steps, between, Task{}));
}

class FirstLook : public ::testing::Test, protected HeardEvents {
 protected:
  FirstLook() {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:64", "torus:12"});
    options.renderer = [control = control_] { return std::make_unique<PlainRenderer>(control); };
    options.least_coarse_cells = 100'000;
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  ~FirstLook() override { engine_.reset(); }

  /// Layers that take eight times as long on all points as on every other.
  static Scene slow(std::uint64_t revision, double upper = 1.2) {
    Scene of = scene(revision, upper, "torus-64");
    of.intervals[0].lower = 0.01;
    for (int i = 0; i < 3; ++i) of.terms.push_back({{RangeOperator::exclusive_or, "distance", {0.1 + 0.1 * i, 0.15 + 0.1 * i}}, {}, "", {}, {}, true});
    return of;
  }

  std::shared_ptr<PlainRendererControl> control_ = std::make_shared<PlainRendererControl>();
  std::unique_ptr<Engine> engine_;
};

TEST_F(FirstLook, IsOfSomePointsAndOfNoRevisionYetAndThatOfAllPointsFollows) {
  engine_->post(SceneUpdate{1, slow(7)});
  engine_->post(frame(1, 1));
  const FrameReady first = frame_of(1);
  EXPECT_EQ(first.point_stride, 2);
  EXPECT_LT(first.revision, 7u) << "who waits for the newest scene goes on asking";
  engine_->post(frame(1, 2));
  const FrameReady second = frame_of(2);
  EXPECT_EQ(second.point_stride, 1);
  EXPECT_EQ(second.revision, 7u);
  EXPECT_GT(second.tetrahedra, 4 * first.tetrahedra);
}

TEST_F(FirstLook, IsNoExactPictureAndNoneForKeeping) {
  engine_->post(SceneUpdate{1, slow(7)});
  engine_->post(frame(1, 1, true));
  FrameRequest still = frame(1, 2);
  still.still = StillFormat::png;
  engine_->post(still);
  for (const RequestId request : {1, 2}) {
    EXPECT_EQ(frame_of(request).point_stride, 1) << request;
    EXPECT_EQ(frame_of(request).revision, 7u) << request;
  }
}

TEST_F(FirstLook, FollowsTheCameraWhileTheLayersOfAllPointsAreFound) {
  engine_->post(SceneUpdate{1, slow(7)});
  engine_->post(frame(1, 1));
  ASSERT_EQ(frame_of(1).point_stride, 2);
  Scene turned = slow(8);
  turned.camera->eye.x += 1;
  engine_->post(SceneUpdate{1, turned});
  engine_->post(frame(1, 2));
  const FrameReady moved = frame_of(2);
  EXPECT_EQ(moved.camera.eye.x, turned.camera->eye.x);
  if (moved.point_stride > 1) {
    EXPECT_LT(moved.revision, 8u);
  }
  engine_->post(frame(1, 3, true));
  EXPECT_EQ(frame_of(3).revision, 8u);
  EXPECT_EQ(frame_of(3).point_stride, 1);
}

TEST_F(FirstLook, OfASmallGridIsThatOfAllPoints) {
  engine_->post(SceneUpdate{1, scene(3)});
  engine_->post(frame(1, 1));
  EXPECT_EQ(frame_of(1).point_stride, 1);
  EXPECT_EQ(frame_of(1).revision, 3u);
}

class InMotion : public ::testing::Test, protected HeardEvents {
 protected:
  InMotion() {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:96", "torus:12", "tets:46"});
    options.renderer = [control = control_] { return std::make_unique<PlainRenderer>(control); };
    options.least_coarse_tetrahedra = 50'000;
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  ~InMotion() override { engine_.reset(); }

  FrameReady ask(int coarse, bool lossless = false) {
    FrameRequest wanted = frame(1, ++request_, lossless);
    wanted.coarse = coarse;
    engine_->post(wanted);
    return frame_of(request_);
  }
  void turn(const char* dataset = "torus-96") {
    Scene next = scene(++revision_, 0.5, dataset);
    next.camera->eye.x += 0.01 * static_cast<double>(revision_);
    engine_->post(SceneUpdate{1, next});
  }

  std::shared_ptr<PlainRendererControl> control_ = std::make_shared<PlainRendererControl>();
  std::unique_ptr<Engine> engine_;
  std::uint64_t revision_ = 0;
  RequestId request_ = 0;
};

TEST_F(InMotion, WhatIsHeavyTurnsAsEveryNthPointOnceThatIsThereAndRestsAsAllPoints) {
  turn();
  const FrameReady exact = ask(0, true);
  EXPECT_EQ(exact.point_stride, 1);
  FrameReady moved;
  for (int tries = 0; tries < 2000 && moved.point_stride == 1; ++tries) {
    turn();
    moved = ask(1);
    EXPECT_EQ(moved.revision, revision_) << "what a hand did is in each picture";
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(moved.point_stride, 2) << "it is made in advance";
  EXPECT_TRUE(moved.coarse_at_hand);
  EXPECT_LT(4 * moved.tetrahedra, exact.tetrahedra);
  EXPECT_NEAR(moved.intervals[0].volume, exact.intervals[0].volume, 0.02 * exact.intervals[0].volume);
  turn();
  EXPECT_EQ(ask(0).point_stride, 1) << "who does not ask for it does not get it";
  const FrameReady rest = ask(0, true);
  EXPECT_EQ(rest.point_stride, 1);
  EXPECT_EQ(rest.tetrahedra, exact.tetrahedra);
  EXPECT_EQ(rest.revision, revision_);

  // Other layers are cut out of all points, and the old coarse ones are not shown for them.
  Scene cut = scene(++revision_, 0.45, "torus-96");
  engine_->post(SceneUpdate{1, cut});
  const FrameReady other = ask(0, true);
  EXPECT_LT(other.intervals[0].volume, exact.intervals[0].volume);
}

TEST_F(InMotion, ADraggedEndIsOfEveryNthPointForWhoAsksAndOfAllPointsForTheOthersAndAtRest) {
  engine_->post(SceneUpdate{1, scene(++revision_, 0.5, "torus-96")});
  const FrameReady exact = ask(0, true);
  const auto drag = [&] { engine_->post(SceneUpdate{1, scene(++revision_, 0.5 - 0.002 * static_cast<double>(revision_), "torus-96")}); };
  FrameReady moved;
  for (int i = 0; i < 4; ++i) {
    drag();
    moved = ask(1);
    EXPECT_EQ(moved.revision, revision_) << "what a hand did is in each picture";
    EXPECT_TRUE(i == 0 || moved.point_stride == 2) << i << ": the first was cut before anybody asked";
  }
  drag();
  const FrameReady other = ask(0);
  EXPECT_EQ(other.point_stride, 1) << "who does not ask for it does not get it";
  EXPECT_EQ(other.revision, revision_);
  drag();
  const FrameReady last = ask(1), rest = ask(0, true);
  EXPECT_EQ(last.point_stride, 2);
  EXPECT_EQ(rest.point_stride, 1);
  EXPECT_EQ(rest.revision, revision_);
  EXPECT_GT(rest.tetrahedra, 4 * last.tetrahedra);
  EXPECT_LT(rest.intervals[0].volume, exact.intervals[0].volume);
  EXPECT_NEAR(last.intervals[0].volume, rest.intervals[0].volume, 0.02 * rest.intervals[0].volume);
}

TEST_F(InMotion, ADraggedEndOfAMeshIsOfItsSamplesForWhoAsksAndOfItsCellsAtRest) {
  engine_->post(SceneUpdate{1, scene(++revision_, 0.5, "tets-46")});
  ask(0, true);
  for (const int level : {1, 3, 2}) {
    FrameReady moved;
    for (int i = 0; i < 3; ++i) {
      engine_->post(SceneUpdate{1, scene(++revision_, 0.5 - 0.002 * static_cast<double>(revision_), "tets-46")});
      moved = ask(level);
      EXPECT_EQ(moved.revision, revision_) << "what a hand did is in each picture";
    }
    EXPECT_GE(moved.point_stride, 2) << level;
    const FrameReady rest = ask(0, true);
    EXPECT_EQ(rest.point_stride, 1);
    EXPECT_EQ(rest.revision, revision_);
    EXPECT_NEAR(moved.intervals[0].volume, rest.intervals[0].volume, 0.02 * rest.intervals[0].volume) << level;
  }
}

TEST_F(InMotion, CoarsePicturesTellHowFarTheyMayBeOffOnceThatIsFound) {
  for (const char* dataset : {"torus-96", "tets-46"}) {
    engine_->post(SceneUpdate{1, scene(++revision_, 0.5, dataset)});
    EXPECT_FALSE(ask(0, true).coarse_error) << "of all points";
    FrameReady moved;
    for (int tries = 0; tries < 2000 && !moved.coarse_error; ++tries) {
      engine_->post(SceneUpdate{1, scene(++revision_, 0.5 - 0.002 * static_cast<double>(tries % 50), dataset)});
      moved = ask(1);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    ASSERT_TRUE(moved.coarse_error) << dataset;
    EXPECT_GE(moved.point_stride, 2);
    EXPECT_GT(moved.coarse_error->largest, moved.coarse_error->mean);
    EXPECT_GT(moved.coarse_error->mean, 0);
    EXPECT_LT(moved.coarse_error->largest, 0.1) << "of a smooth field whose values are 0 to 3";
  }
}

TEST(CoarseScenes, FindTheirErrorOnceAndNotOfWhatIsLargerThanMemory) {
  const auto whole = make_analytic("torus:65", {}, Task{});
  CoarseScenes scenes(1000);
  const auto coarse = scenes.extract_for_motion(whole, torus_scene(), 3, Task{});
  ASSERT_TRUE(coarse && coarse->coarse_error);
  scenes.find_error(coarse->dataset, coarse->array, static_cast<std::uint64_t>(whole->grid.point_count()), Task{});  // a value has four bytes
  EXPECT_FALSE(coarse->coarse_error->get());
  scenes.find_error(coarse->dataset, coarse->array, 1 << 30, Task{});
  ASSERT_TRUE(coarse->coarse_error->get());
  const auto stride = moving_stride(whole->grid, 3);
  EXPECT_EQ(coarse->coarse_error->get()->largest, coarse_error(*whole, *coarse->dataset, stride, coarse->array, Task{}).largest);
  Scene moved = torus_scene();
  moved.intervals[0].upper *= 0.9;
  EXPECT_EQ(scenes.extract_for_motion(whole, moved, 3, Task{})->coarse_error, coarse->coarse_error) << "other layers of the same points";
}

TEST_F(InMotion, AHeavyMeshTurnsAsItsSamplesSoonAfterItIsSeen) {
  turn("tets-46");
  ask(0);
  FrameReady moved;
  for (int tries = 0; tries < 2000 && moved.point_stride == 1; ++tries) {
    turn("tets-46");
    moved = ask(1);
    EXPECT_EQ(moved.revision, revision_);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(moved.point_stride, 2);
}

TEST(CoarseScenes, OfLabelsThatAreTakenWholeThereAreNone) {
  const auto mesh = make_analytic("tets:46", {}, Task{});
  Scene scene = torus_scene();
  const auto extracted = extract_scene(mesh, scene, nullptr, Task{});
  EXPECT_TRUE(can_be_coarse(*extracted, scene));
  CoarseScenes scenes(1000);
  EXPECT_TRUE(scenes.extract_for_motion(mesh, scene, 1, Task{}));
  scene.values = FieldValues::whole;
  EXPECT_FALSE(can_be_coarse(*extracted, scene)) << "else it would be asked for again and again";
  EXPECT_FALSE(scenes.extract_for_motion(mesh, scene, 1, Task{}));
}

TEST(CoarseScenes, OfCellsAroundPointsThereAreNone) {
  const auto whole = std::make_shared<Dataset>(*make_analytic("torus:165", {}, Task{}));  // above 2^22 points, from where on boxes that move are coarser
  whole->arrays.resize(1);
  auto labels = std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(whole->grid.point_count()));
  for (std::size_t i = 0; i < labels->size(); ++i) (*labels)[i] = i % 165 < 20 ? 1 : 0;
  PointArray& array = whole->arrays[0];
  array.type = ScalarType::uint8;
  array.values = std::span<const std::uint8_t>(*labels);
  array.storage = labels;
  measure_range(array);
  Scene scene = torus_scene();
  scene.values = FieldValues::whole;
  scene.intervals.resize(1);
  scene.intervals[0].lower = 0.5, scene.intervals[0].upper = 1.5;
  const auto extracted = extract_scene(whole, scene, nullptr, Task{});
  ASSERT_GT(extracted->mesh->tetrahedra.size(), 1000u);
  EXPECT_FALSE(can_be_coarse(*extracted, scene)) << "their points have no values";
  CoarseScenes scenes(1000);
  EXPECT_FALSE(scenes.extract_for_motion(extracted->dataset, scene, 1, Task{}));
}

TEST_F(InMotion, TheRestOfEveryDragIsExactHoweverItsRequestsMeet) {
  const unsigned seed = std::random_device{}();
  std::mt19937 random(seed);
  const auto pause = [&] { std::this_thread::sleep_for(std::chrono::microseconds(random() % 6000)); };
  engine_->post(SceneUpdate{1, scene(++revision_, 0.5, "torus-96")});
  ask(0, true);
  for (int i = 0; i < 30; ++i) {
    engine_->post(SceneUpdate{1, scene(++revision_, 0.5 - 0.002 * (1 + i % 40), "torus-96")});
    pause();
    for (const int coarse : {0, 1}) {  // the gesture's first frame is forecast anew while the layers are found
      FrameRequest moving = frame(1, ++request_);
      moving.coarse = coarse;
      engine_->post(moving);
      if (coarse == 0) engine_->post(ForgetFrame{1, request_});
    }
    pause();
    const FrameReady rest = ask(0, true);
    ASSERT_EQ(rest.revision, revision_) << "seed " << seed << ", drag " << i;
    ASSERT_EQ(rest.point_stride, 1);
  }
}

TEST_F(InMotion, AnEndOfASmallGridIsDraggedAsAllPoints) {
  turn("torus-12");
  ask(0, true);
  for (int i = 0; i < 3; ++i) {
    engine_->post(SceneUpdate{1, scene(++revision_, 0.5 - 0.01 * i, "torus-12")});
    const FrameReady moved = ask(1);
    EXPECT_EQ(moved.point_stride, 1);
    EXPECT_EQ(moved.revision, revision_);
  }
}

TEST_F(InMotion, WhatIsLightTurnsAsAllPoints) {
  turn("torus-12");
  ask(0, true);
  for (int i = 0; i < 5; ++i) {
    turn("torus-12");
    const FrameReady moved = ask(1);
    EXPECT_EQ(moved.point_stride, 1);
    EXPECT_FALSE(moved.coarse_at_hand);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace
}  // namespace isostrata
