// What is extracted next, and what a picture shows until it is there: plain state, without threads.
#include "engine/engine/latest_extraction.h"

#include <gtest/gtest.h>

#include "data/dataset/analytic.h"

namespace isostrata {
namespace {

using Next = LatestExtraction::Next;

Scene scene(std::uint64_t revision, double upper, int step = 0) {
  Scene scene;
  scene.dataset = "d";
  scene.step = step;
  scene.revision = revision;
  scene.intervals.resize(1);
  scene.intervals[0].upper = upper;
  return scene;
}

std::shared_ptr<const ExtractedScene> extracted(int stride, double ms = 1) {
  static const std::shared_ptr<const Dataset> large = make_analytic("torus:64", {}, Task{});  // every n-th point of it will do
  auto extracted = std::make_shared<ExtractedScene>();
  extracted->dataset = large;
  extracted->mesh = std::make_shared<const IntervalMesh>();
  extracted->point_stride = stride;
  extracted->extract_ms = ms;
  return extracted;
}

FrameRequest moving(int coarse = 0) {
  FrameRequest request;
  request.coarse = coarse;
  return request;
}

FrameRequest lossless() {
  FrameRequest request;
  request.lossless = true;
  return request;
}

class LatestExtractionTest : public ::testing::Test {
 protected:
  std::shared_ptr<Operation> begin(bool coarse = false) {
    auto operation = std::make_shared<Operation>(1, 0, ++operations_, [](EngineEvent) {});
    latest_.begin(operation, coarse);
    return operation;
  }
  static RequestFailed failure() { return {1, 0, 0, ErrorCode::not_found, "no such array"}; }

  LatestExtraction latest_;
  std::uint64_t operations_ = 0;
};

TEST_F(LatestExtractionTest, ASceneIsExtractedOnceAndOnlyIfItHasADataset) {
  EXPECT_EQ(latest_.next(false), Next::nothing);
  Scene empty = scene(1, 0.5);
  empty.dataset.clear();
  latest_.take(empty);
  EXPECT_EQ(latest_.next(false), Next::nothing);
  latest_.take(scene(2, 0.5));
  EXPECT_EQ(latest_.next(false), Next::extract);
  begin();
  EXPECT_EQ(latest_.next(false), Next::nothing);
  EXPECT_EQ(latest_.end({}), nullptr);
  latest_.take_ready(extracted(1), scene(2, 0.5));
  EXPECT_EQ(latest_.next(false), Next::nothing);
  Scene turned = scene(3, 0.5);
  turned.background = {1, 0, 0};
  latest_.take(turned);
  EXPECT_EQ(latest_.next(false), Next::nothing) << "a view needs no extraction";
  latest_.give_back();
  EXPECT_EQ(latest_.next(false), Next::extract);
}

TEST_F(LatestExtractionTest, ADragOvertakesWhatRunsAfterItsGraceAndOtherDataAtOnce) {
  latest_.take(scene(1, 0.5));
  begin();
  latest_.take(scene(2, 0.4));
  EXPECT_EQ(latest_.next(false), Next::overtake_after_grace);
  latest_.take(scene(3, 0.5));
  EXPECT_EQ(latest_.next(false), Next::nothing) << "it is wanted again";
  latest_.take(scene(4, 0.5, 1));
  EXPECT_EQ(latest_.next(false), Next::overtake_at_once);
}

TEST_F(LatestExtractionTest, OfTwoInARowAtMostOneIsCutShort) {
  latest_.take(scene(1, 0.5));
  auto running = begin();
  latest_.take(scene(2, 0.4));
  ASSERT_EQ(latest_.next(false), Next::overtake_after_grace);
  running->supersede(0);
  EXPECT_EQ(latest_.end(failure()), nullptr);
  EXPECT_EQ(latest_.next(false), Next::extract);
  begin();
  latest_.take(scene(3, 0.3));
  EXPECT_EQ(latest_.next(false), Next::nothing) << "the second is shown, however long it takes";
  latest_.end({});
  latest_.take_ready(extracted(1), scene(2, 0.4));
  ASSERT_EQ(latest_.next(false), Next::extract);
  begin();
  latest_.take(scene(4, 0.2));
  EXPECT_EQ(latest_.next(false), Next::overtake_after_grace);
}

TEST_F(LatestExtractionTest, AFailureStaysUntilTheSceneIsAnotherOrTheFilesAre) {
  latest_.take(scene(1, 0.5));
  begin();
  Scene turned = scene(2, 0.5);
  turned.background = {1, 0, 0};
  latest_.take(turned);
  const RequestFailed* told = latest_.end(failure());
  ASSERT_TRUE(told);
  EXPECT_EQ(told->revision, 2u) << "of the newest scene, for which the same would be extracted";
  EXPECT_EQ(told->message, "no such array");
  EXPECT_EQ(latest_.next(false), Next::nothing);
  latest_.take(scene(3, 0.5));
  EXPECT_EQ(latest_.next(false), Next::nothing);
  latest_.forget_failure();
  EXPECT_EQ(latest_.next(false), Next::extract);
  begin();
  ASSERT_TRUE(latest_.end(failure()));
  latest_.take(scene(4, 0.4));
  EXPECT_EQ(latest_.next(false), Next::extract);
}

TEST_F(LatestExtractionTest, TheFailureOfWhatNobodyWantsIsNotTold) {
  latest_.take(scene(1, 0.5));
  begin();
  latest_.take(scene(2, 0.4));
  EXPECT_EQ(latest_.end(failure()), nullptr) << "of an older scene";
  EXPECT_EQ(latest_.next(false), Next::extract);
  auto given_up = begin();
  given_up->supersede(0);
  EXPECT_EQ(latest_.end(failure()), nullptr) << "given up, and wanted again by now";
  EXPECT_FALSE(latest_.failure());
  EXPECT_EQ(latest_.next(false), Next::extract);
}

TEST_F(LatestExtractionTest, AMovingHandThatAsksForSomePointsGetsThemOfWhatIsReady) {
  latest_.take(scene(1, 0.5));
  latest_.ask_for(1);
  EXPECT_EQ(latest_.next(true), Next::extract) << "nothing is ready that they could be taken of";
  latest_.take_ready(extracted(1), scene(1, 0.5));
  latest_.take(scene(2, 0.4));
  EXPECT_EQ(latest_.next(true), Next::extract_coarse);
  EXPECT_EQ(latest_.next(false), Next::extract) << "somebody waits for all points";
  begin(true);
  EXPECT_EQ(latest_.next(true), Next::nothing);
  latest_.take(scene(3, 0.3));
  EXPECT_EQ(latest_.next(true), Next::overtake_after_grace);
  latest_.end({});
  latest_.take_coarse(extracted(2), scene(3, 0.3));
  EXPECT_EQ(latest_.next(true), Next::nothing);
  EXPECT_EQ(latest_.next(false), Next::extract);
  begin();
  EXPECT_EQ(latest_.next(true), Next::overtake_at_once) << "all points are for nobody while the hand moves";
  latest_.take(scene(4, 0.3, 1));
  EXPECT_FALSE(latest_.coarse_suffices(true)) << "they would be of another step";
}

TEST_F(LatestExtractionTest, NothingIsShownBeforeAnythingIsReady) {
  latest_.take(scene(1, 0.5));
  EXPECT_FALSE(latest_.show(moving()));
}

TEST_F(LatestExtractionTest, WhatIsReadyIsShownAsTheNewestSceneAndItsExtractionIsToldOnce) {
  latest_.take(scene(2, 0.5));
  latest_.take_ready(extracted(1, 7), scene(1, 0.5));
  const auto first = latest_.show(moving()), second = latest_.show(lossless());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->scene.revision, 2u);
  EXPECT_EQ(first->extract_ms, 7);
  EXPECT_EQ(second->extract_ms, 0);
}

TEST_F(LatestExtractionTest, OlderLayersAreShownOnceForEachViewAndNeverAsExact) {
  Scene newest = scene(2, 0.4);
  latest_.take(newest);
  latest_.take_ready(extracted(1), scene(1, 0.5));
  EXPECT_FALSE(latest_.show(lossless()));
  const auto meanwhile = latest_.show(moving());
  ASSERT_TRUE(meanwhile);
  EXPECT_EQ(meanwhile->scene.revision, 1u);
  EXPECT_FALSE(latest_.show(moving())) << "the same view again";
  newest.background = {1, 0, 0};
  latest_.take(newest);
  EXPECT_TRUE(latest_.show(moving())) << "another one";
  newest.light.fade = 0.5;
  latest_.take(newest);
  const auto lit = latest_.show(moving());
  ASSERT_TRUE(lit) << "another light";
  EXPECT_EQ(lit->scene.light, newest.light);
}

TEST_F(LatestExtractionTest, WhatIsNotDrawnAfterAllIsShownAgain) {
  latest_.take(scene(1, 0.5));
  latest_.take_ready(extracted(1, 7), scene(1, 0.5));
  const auto before = latest_.mark();
  EXPECT_EQ(latest_.show(moving())->extract_ms, 7);
  latest_.undo_show(before);
  EXPECT_EQ(latest_.show(moving())->extract_ms, 7);
  latest_.take(scene(2, 0.4));
  Scene turned = scene(3, 0.4);
  turned.background = {1, 0, 0};
  latest_.take(turned);
  const auto older = latest_.mark();
  ASSERT_TRUE(latest_.show(moving()));
  ASSERT_FALSE(latest_.show(moving()));
  latest_.undo_show(older);
  EXPECT_TRUE(latest_.show(moving()));
}

TEST_F(LatestExtractionTest, EveryNthPointIsForWhoAsksForItAndCountsAsTheNewestScene) {
  latest_.take(scene(1, 0.5));
  latest_.take_ready(extracted(1, 7), scene(1, 0.5));
  latest_.show(moving());
  latest_.take(scene(3, 0.4));
  latest_.take_coarse(extracted(2, 1), scene(3, 0.4));
  EXPECT_FALSE(latest_.show(moving())) << "who waits for all points: what is ready has been seen";
  const auto shown = latest_.show(moving(1));
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->extracted->point_stride, 2);
  EXPECT_EQ(shown->scene.revision, 3u);
  EXPECT_TRUE(shown->coarse_at_hand);
  EXPECT_EQ(shown->extract_ms, 1);
}

TEST_F(LatestExtractionTest, OfTwoThatAreOldTheNewerIsShown) {
  latest_.take(scene(4, 0.3));
  latest_.take_ready(extracted(1), scene(1, 0.5));
  latest_.take_coarse(extracted(2), scene(3, 0.4));
  const auto shown = latest_.show(moving(1));
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->scene.revision, 3u);
  EXPECT_EQ(shown->extracted->point_stride, 2);
}

TEST_F(LatestExtractionTest, WhatWasMadeInAdvanceDoesNotReplaceWhatAHandHasCutSince) {
  latest_.take(scene(3, 0.3));
  latest_.take_ready(extracted(1), scene(1, 0.5));
  const auto cut = extracted(2);
  latest_.take_coarse(cut, scene(3, 0.3));
  latest_.take_coarse(extracted(2), scene(1, 0.5));
  const auto shown = latest_.show(moving(1));
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->extracted, cut);
  EXPECT_EQ(shown->scene.revision, 3u);
  const auto next_cut = extracted(2);
  latest_.take(scene(4, 0.2));
  latest_.take_coarse(next_cut, scene(4, 0.2));
  EXPECT_EQ(latest_.coarse_for(*latest_.scene()), next_cut);
}

TEST_F(LatestExtractionTest, EveryNthPointOfOtherLayersGoesOnceAllPointsAreReady) {
  latest_.take(scene(1, 0.5));
  latest_.take_coarse(extracted(2), scene(1, 0.5));
  latest_.take_ready(extracted(1), scene(1, 0.5));
  EXPECT_TRUE(latest_.coarse().extracted) << "it is of these layers, for the hand that turns them";
  latest_.take_ready(extracted(1), scene(2, 0.4));
  EXPECT_FALSE(latest_.coarse().extracted);
}

TEST_F(LatestExtractionTest, AFirstLookContainsNoSceneWhollyAndIsNotForStills) {
  latest_.take(scene(5, 0.5));
  latest_.take_first_look(extracted(4), scene(5, 0.5));
  EXPECT_EQ(latest_.ready_for(*latest_.scene()), nullptr);
  FrameRequest still = moving();
  still.still = StillFormat::png;
  EXPECT_FALSE(latest_.show(still));
  const auto shown = latest_.show(moving());
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->scene.revision, 4u);
}

TEST_F(LatestExtractionTest, WhatIsGivenBackIsHeldByNobodyElse) {
  latest_.take(scene(1, 0.5));
  latest_.take_ready(extracted(1), scene(1, 0.5));
  latest_.take_coarse(extracted(2), scene(1, 0.5));
  const std::weak_ptr<const ExtractedScene> ready = latest_.ready().extracted, coarse = latest_.coarse().extracted;
  {
    const auto given_back = latest_.give_back();
    EXPECT_FALSE(ready.expired() || coarse.expired()) << "the caller drops it";
  }
  EXPECT_TRUE(ready.expired() && coarse.expired());
  EXPECT_EQ(latest_.bytes(), 0u);
}

}  // namespace
}  // namespace isostrata
