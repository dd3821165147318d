#include "worker/message_bytes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace isostrata {
namespace {

Scene full_scene() {
  Scene scene;
  scene.revision = 1ull << 60;
  scene.dataset = "torus-12";
  scene.step = 3;
  scene.array = "distance";
  scene.texture = std::string("a\0b", 3);
  SceneInterval interval{7, -1.5, std::numeric_limits<double>::infinity(), {0.1f, 0.2f, 0.3f}, "viridis", 0.25, -4, false};
  interval.opacity_upper = 0.75;
  interval.surface.texture = "stripes";
  interval.name = "skin";
  scene.intervals = {interval, SceneInterval{}};
  SceneTerm term;
  term.term.op = RangeOperator::subtract;
  term.term.array = "b";
  term.color = Rgb{1, 0, 1};
  term.priority = -2;
  scene.terms = {term};
  scene.time = 2.5;
  scene.time_mode = TimeMode::spacetime;
  scene.mode = SceneMode::smear;
  scene.smear = {{1, 2, 3}, {Rgb{1, 1, 0}}};
  scene.camera = Camera{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, 33, true};
  scene.clip_planes = {ClipPlane{{0, 1, 0}, -3}};
  scene.annotations.legend = true;
  return scene;
}

FrameReady full_frame(std::size_t bytes) {
  FrameReady frame;
  frame.session = 3;
  frame.request = 4;
  frame.revision = 5;
  frame.camera.eye.x = 12;
  frame.stages.encode_ms = 1.25;
  frame.device = "plain";
  frame.intervals = {{1, 2, 3, 4.5}};
  frame.bytes = std::make_shared<const Bytes>(bytes, std::uint8_t{42});
  frame.video = VideoFacts{Codec::vp9_444, 8, true};
  return frame;
}

DatasetReady full_dataset() {
  DatasetReady ready{1, 2, {}};
  ready.facts.name = "n";
  ready.facts.cell_types = {{"hexahedron", 12}, {"wedge", 1}};
  ready.facts.bounds.include({1, 2, 3});
  ready.facts.arrays = {{"a", "point", "float32", 1, 0, 1, 9}};
  ready.facts.times = {0, 0.5};
  ready.facts.first_view.array = "a";
  ready.facts.first_view.layers = {{0.25, 0.5, {0.5f, 0.25f, 1}, 0.75, {}, "skin", "why"}};
  ready.facts.first_view.layers[0].surface.lower = true;
  ready.facts.first_view.outline = {{1, 2, 3}, {4, 5, 6}};
  ready.facts.first_view.camera_reason = "that";
  return ready;
}

TEST(MessageBytes, ASceneArrivesAsItWas) {
  const Scene scene = full_scene();
  const ToWorker arrived = to_worker(to_bytes(ToWorker{EngineRequest{SceneUpdate{9, scene}}}));
  const auto& update = std::get<SceneUpdate>(std::get<EngineRequest>(arrived));
  EXPECT_EQ(update.session, 9u);
  EXPECT_EQ(update.scene.revision, scene.revision);
  EXPECT_EQ(update.scene.texture, scene.texture);
  EXPECT_EQ(update.scene.intervals, scene.intervals);
  EXPECT_EQ(update.scene.terms, scene.terms);
  EXPECT_EQ(update.scene.time, scene.time);
  EXPECT_EQ(update.scene.mode, SceneMode::smear);
  EXPECT_EQ(update.scene.smear, scene.smear);
  EXPECT_EQ(update.scene.camera, scene.camera);
  EXPECT_EQ(update.scene.clip_planes, scene.clip_planes);
  EXPECT_EQ(update.scene.annotations, scene.annotations);
}

TEST(MessageBytes, AFrameArrivesWithItsPictureBesideIt) {
  const MessageBytes bytes = to_bytes(FromWorker{EngineEvent{full_frame(1000)}});
  EXPECT_LT(bytes.body.size(), 700u) << "the picture is not copied into the message";
  ASSERT_TRUE(bytes.picture);
  const FromWorker arrived = from_worker(bytes);
  const auto& frame = std::get<FrameReady>(std::get<EngineEvent>(arrived));
  EXPECT_EQ(frame.camera.eye.x, 12);
  EXPECT_EQ(frame.stages.encode_ms, 1.25);
  ASSERT_EQ(frame.intervals.size(), 1u);
  EXPECT_EQ(frame.intervals[0].volume, 4.5);
  EXPECT_EQ(*frame.bytes, Bytes(1000, 42));
  ASSERT_TRUE(frame.video);
  EXPECT_EQ(frame.video->codec, Codec::vp9_444);
  EXPECT_TRUE(frame.video->key);
}

TEST(MessageBytes, APictureInBandsArrives) {
  FrameReady sent;
  sent.bands = std::make_shared<const std::vector<PngBand>>(std::vector<PngBand>{{0, 4, {1, 2, 3}}, {4, 2, {4}}});
  const FromWorker arrived = from_worker(to_bytes(FromWorker{EngineEvent{sent}}));
  const auto& frame = std::get<FrameReady>(std::get<EngineEvent>(arrived));
  EXPECT_FALSE(frame.bytes);
  ASSERT_TRUE(frame.bands);
  ASSERT_EQ(frame.bands->size(), 2u);
  EXPECT_EQ((*frame.bands)[0].bytes, (Bytes{1, 2, 3}));
  EXPECT_EQ((*frame.bands)[1].first_row, 4);
}

TEST(MessageBytes, FactsOfADatasetArriveAsTheyWere) {
  const DatasetReady ready = full_dataset();
  const FromWorker arrived = from_worker(to_bytes(FromWorker{EngineEvent{ready}}));
  const auto& facts = std::get<DatasetReady>(std::get<EngineEvent>(arrived)).facts;
  EXPECT_EQ(facts.cell_types, ready.facts.cell_types);
  EXPECT_EQ(facts.bounds.upper, ready.facts.bounds.upper);
  ASSERT_EQ(facts.arrays.size(), 1u);
  EXPECT_EQ(facts.arrays[0].nan_count, 9);
  EXPECT_EQ(facts.first_view, ready.facts.first_view);
}

TEST(MessageBytes, WhatIsCutShortOrTooLongIsRefused) {
  for (const FromWorker& message : {FromWorker{EngineEvent{full_frame(10)}}, FromWorker{EngineEvent{full_dataset()}},
                                    FromWorker{WorkerRefused{ErrorCode::unavailable, "no device"}}}) {
    const MessageBytes whole = to_bytes(message);
    for (std::size_t size = 0; size < whole.body.size(); ++size)
      EXPECT_THROW(from_worker({whole.body.substr(0, size), whole.picture}), Error) << size << " of " << whole.body.size();
    EXPECT_THROW(from_worker({whole.body + '\0', whole.picture}), Error);
  }
}

TEST(MessageBytes, DamageIsAnErrorOrAnotherMessageAndNeverMore) {
  const std::string whole = to_bytes(ToWorker{EngineRequest{SceneUpdate{9, full_scene()}}}).body;
  const unsigned seed = 5;
  std::mt19937 random(seed);
  int refused = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string damaged = whole;
    for (int n = 1 + static_cast<int>(random() % 3); n > 0; --n) damaged[random() % damaged.size()] = static_cast<char>(random());
    try {
      const ToWorker message = to_worker({damaged, nullptr});
      EXPECT_EQ(to_bytes(message).body, damaged) << "seed " << seed << ", round " << i;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_data);
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(MessageBytes, ACountThatLiesTakesNoMemory) {
  // A histogram with 2^60 counts, in a message of a few bytes.
  std::string body = to_bytes(FromWorker{EngineEvent{HistogramReady{}}}).body;
  const std::uint64_t count = 1ull << 60;
  body.replace(body.size() - 8, 8, reinterpret_cast<const char*>(&count), 8);
  EXPECT_THROW(from_worker({body, nullptr}), Error);
}

}  // namespace
}  // namespace isostrata
