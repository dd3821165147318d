// What is made before anybody waits for it: pure rules, and what it holds.
#include "engine/engine/work_ahead.h"

#include <gtest/gtest.h>

#include <future>

#include "data/dataset/analytic.h"
#include "extraction/surfaces/base_tetrahedra.h"

namespace isostrata {
namespace {

using What = Preparation::What;

Scene at_step(int step, const std::string& dataset = "d") {
  Scene scene;
  scene.dataset = dataset;
  scene.step = step;
  return scene;
}

TEST(StepAhead, IsTheOneBehindTheLastTwoInTheirDirection) {
  EXPECT_EQ(step_ahead(at_step(5), at_step(4), 10), 6);
  EXPECT_EQ(step_ahead(at_step(4), at_step(5), 10), 3);
  EXPECT_EQ(step_ahead(at_step(9), at_step(8), 10), std::nullopt);
  EXPECT_EQ(step_ahead(at_step(0), at_step(1), 10), std::nullopt);
}

TEST(StepAhead, IsReadForWhoGoesStepByStepThroughOneSeries) {
  EXPECT_EQ(step_ahead(at_step(5), at_step(5), 10), std::nullopt);
  EXPECT_EQ(step_ahead(at_step(5), at_step(3), 10), std::nullopt);
  EXPECT_EQ(step_ahead(at_step(5), at_step(4, "another"), 10), std::nullopt);
  Scene between = at_step(5);
  between.time = 4.5;
  EXPECT_EQ(step_ahead(between, at_step(4), 10), std::nullopt);
  EXPECT_EQ(step_ahead(at_step(5), between, 10), std::nullopt);
}

class ToPrepare : public ::testing::Test {
 protected:
  static std::shared_ptr<const Dataset> opened(const std::string& name) { return make_analytic(name, {}, Task{}); }
  Scene scene(double upper) const {
    Scene scene;
    scene.array = dataset_->arrays[0].name;
    scene.intervals.resize(1);
    scene.intervals[0].lower = 0.1;
    scene.intervals[0].upper = upper;
    return scene;
  }
  ExtractedScene extracted(double upper, const std::shared_ptr<const Dataset>& dataset) const {
    ExtractedScene extracted;
    extracted.request = layer_request(scene(upper));
    extracted.array = dataset->arrays[0].name;
    extracted.dataset = dataset;
    extracted.steps = {dataset};
    return extracted;
  }
  Preparation prepared(const ExtractedScene& of, const ExtractedScene* previous) {
    return to_prepare(of, scene(of.request.intervals[0].upper), previous,
                      {renderer_cuts_, max_bytes_, [this] { return has_base_; }, [this] { return knows_order_; }, [this] { return knows_faces_; }});
  }

  std::shared_ptr<const Dataset> dataset_ = opened("tets:6");
  bool renderer_cuts_ = true, has_base_ = false, knows_order_ = false, knows_faces_ = false;
  std::uint64_t max_bytes_ = std::uint64_t{1} << 30;
};

TEST_F(ToPrepare, WhatHasJustBeenOpenedIsMadeReadyForLaterIfItTakesLittle) {
  EXPECT_EQ(prepared(extracted(0.5, dataset_), nullptr), (Preparation{What::base, false}));
  max_bytes_ = 8 * base_tetrahedra_bytes(*dataset_);
  EXPECT_EQ(prepared(extracted(0.5, dataset_), nullptr).what, What::base);
  --max_bytes_;
  EXPECT_EQ(prepared(extracted(0.5, dataset_), nullptr), Preparation{});
}

TEST_F(ToPrepare, ASeriesThatHasJustBeenOpenedIsLaidOutForItsOtherSteps) {
  auto series = std::make_shared<Dataset>(*dataset_);
  series->times = {0, 1};
  EXPECT_EQ(prepared(extracted(0.5, series), nullptr), (Preparation{What::order, false}));
  const ExtractedScene before = extracted(0.5, series), moved = extracted(0.4, series);
  EXPECT_EQ(prepared(moved, &before), (Preparation{What::base, true})) << "a hand at one of its steps";
}

TEST_F(ToPrepare, AHandThatMovesAnEndWaitsForIt) {
  const ExtractedScene before = extracted(0.5, dataset_), moved = extracted(0.4, dataset_);
  max_bytes_ = 1;
  EXPECT_EQ(prepared(moved, &before), (Preparation{What::base, true})) << "whatever it takes";
  EXPECT_EQ(prepared(before, &before), Preparation{}) << "nothing has moved";
  ExtractedScene with_facets = before;
  with_facets.request.facets = !before.request.facets;
  EXPECT_EQ(prepared(with_facets, &before), Preparation{}) << "no end has moved";
}

TEST_F(ToPrepare, ExtractionIsMadeQuickerIfTheRendererCannotCutOrHasWhatItCuts) {
  const ExtractedScene before = extracted(0.5, dataset_), moved = extracted(0.4, dataset_);
  has_base_ = true;
  EXPECT_EQ(prepared(moved, &before), (Preparation{What::order, true}));
  knows_order_ = true;
  EXPECT_EQ(prepared(moved, &before), Preparation{});
  has_base_ = knows_order_ = renderer_cuts_ = false;
  EXPECT_EQ(prepared(moved, &before), (Preparation{What::order, true}));
  ExtractedScene combined = moved;
  combined.request.terms.resize(1);
  EXPECT_EQ(prepared(combined, &before), Preparation{});
}

TEST_F(ToPrepare, StepsThatArePlayedOnOneMeshShareItsOrder) {
  auto next_step = std::make_shared<Dataset>(*dataset_);
  next_step->step = 1;
  const ExtractedScene before = extracted(0.5, dataset_);
  EXPECT_EQ(prepared(extracted(0.5, next_step), &before), (Preparation{What::order, false})) << "who plays a long series has waited for it";
  EXPECT_EQ(prepared(extracted(0.5, opened("tets:6")), &before), (Preparation{What::base, false})) << "another mesh has been opened";
}

TEST_F(ToPrepare, TheFacesOfOtherCellsAreLookedForOnce) {
  const auto mesh = opened("mixed:6");
  ExtractedScene before = extracted(0.5, mesh), moved = extracted(0.4, mesh);
  before.request.facets = moved.request.facets = true;
  EXPECT_EQ(prepared(before, nullptr), (Preparation{What::faces, false}));
  EXPECT_EQ(prepared(moved, &before), (Preparation{What::faces, true})) << "a hand waits";
  auto next_step = std::make_shared<Dataset>(*mesh);
  next_step->step = 1;
  ExtractedScene played = extracted(0.5, next_step);
  played.request.facets = true;
  EXPECT_EQ(prepared(played, &before), (Preparation{What::faces, true})) << "so does who plays";
  knows_faces_ = true;
  EXPECT_EQ(prepared(moved, &before), Preparation{});
  knows_faces_ = false;
  before.request.facets = false;
  EXPECT_EQ(prepared(before, nullptr), Preparation{}) << "none are asked for";
}

TEST_F(ToPrepare, OtherGridsAndWhatIsCutAlreadyNeedNothing) {
  EXPECT_EQ(prepared(extracted(0.5, opened("torus:12")), nullptr), Preparation{});
  ExtractedScene cut = extracted(0.5, dataset_);
  cut.base = std::make_shared<const BaseTetrahedra>();
  EXPECT_EQ(prepared(cut, nullptr), Preparation{});
}

/// Steps of tets:6 on one mesh.
class LayOutPlayed : public ::testing::Test {
 protected:
  static constexpr int kSteps = 6;
  LayOutPlayed() {
    for (int step = 0; step < kSteps; ++step) {
      auto dataset = step == 0 ? make_analytic("tets:6", {}, Task{}) : steps_[0];
      auto copy = std::make_shared<Dataset>(*dataset);
      copy->step = step;
      copy->times.assign(kSteps, 0);
      steps_.push_back(std::move(copy));
    }
    before_.dataset = steps_[0];
    before_.array = steps_[0]->arrays[0].name;
  }
  bool lays_out(int step, int before) {
    SharedMeshes shared(1000, std::uint64_t{1} << 30);
    WorkAhead ahead({.max_bytes = std::uint64_t{1} << 30}, datasets_, shared, {.wants_coarse = [](auto&&...) { return false; }, .take_coarse = [](auto&&...) {}});
    ahead.lay_out_played(1, at_step(step), before_, at_step(before), [this](int of, const Task&) { return steps_.at(static_cast<std::size_t>(of)); }, Task{});
    return shared.ordered.find(steps_[0]->grid, steps_[0]->arrays[0], Task{}).tetrahedra != nullptr;
  }

  OpenDatasets datasets_{Catalogue::from_sources({"tets:6"}), {}, nullptr};
  std::vector<std::shared_ptr<const Dataset>> steps_;
  ExtractedScene before_;
};

TEST_F(LayOutPlayed, AStepThatOthersWillFollowWaitsForTheLayoutOfTheirMesh) {
  EXPECT_TRUE(lays_out(1, 0));
  EXPECT_TRUE(lays_out(2, 1));
  EXPECT_TRUE(lays_out(4, 5)) << "backwards";
  EXPECT_FALSE(lays_out(3, 2)) << "two that follow do not pay for it";
  EXPECT_FALSE(lays_out(2, 3)) << "backwards, too";
  EXPECT_FALSE(lays_out(2, 0)) << "a jump";
}

TEST_F(LayOutPlayed, WhatIsNotSplitSoonerByItDoesNotWait) {
  before_.base = std::make_shared<const BaseTetrahedra>();
  EXPECT_FALSE(lays_out(1, 0)) << "is cut where it is drawn";
  before_.base.reset();
  before_.request.terms.resize(1);
  EXPECT_FALSE(lays_out(1, 0)) << "combined ranges have a grid of their own";
  before_.request.terms.clear();
  steps_[1] = make_analytic("tets:6", {}, Task{});
  EXPECT_FALSE(lays_out(1, 0)) << "the mesh has moved";
}

TEST(WorkAhead, AHandThatMovesLayersOfALargeMeshFindsItsSamples) {
  OpenDatasets datasets(Catalogue::from_sources({"tets:45"}), {}, nullptr);
  SharedMeshes shared(1000, std::uint64_t{1} << 30);
  auto extracted = std::make_shared<ExtractedScene>();
  extracted->dataset = make_analytic("tets:45", {}, Task{});
  extracted->mesh = std::make_shared<const IntervalMesh>();
  Scene scene;
  scene.array = extracted->dataset->arrays[0].name;
  scene.intervals.resize(1);
  std::promise<bool> asked;
  {
    WorkAhead ahead({.max_bytes = std::uint64_t{1} << 30, .least_coarse_tetrahedra = 1'000'000}, datasets, shared,
                    {.wants_coarse =
                         [&](auto&&...) {
                           asked.set_value(true);
                           return true;
                         },
                     .take_coarse = [](auto&&...) { ADD_FAILURE() << "few tetrahedra are turned as they are"; }});
    ahead.prepare_motion(1, extracted, scene);
    asked.get_future().wait();
  }  // waits for what has begun
  EXPECT_GT(shared.coarse.held_bytes(), 0u);
}

TEST(WorkAhead, WhatWaitsToBeComparedHoldsNoLayers) {
  OpenDatasets datasets(Catalogue::from_sources({"torus:65"}), {}, nullptr);
  SharedMeshes shared(1000, std::uint64_t{1} << 30);
  const auto whole = make_analytic("torus:65", {}, Task{});
  Scene scene;
  scene.array = whole->arrays[0].name;
  scene.intervals.resize(1);
  scene.intervals[0].lower = 0.1;
  WorkAhead ahead({.max_bytes = std::uint64_t{1} << 30}, datasets, shared,
                  {.wants_coarse = [](auto&&...) { return false; }, .take_coarse = [](auto&&...) {}});
  std::vector<std::weak_ptr<const ExtractedScene>> moved;
  for (int i = 0; i < 20; ++i) {
    scene.intervals[0].upper = 0.5 - 0.01 * i;
    const auto coarse = shared.coarse.extract_for_motion(whole, scene, 1, Task{});
    ahead.find_error(*coarse);
    moved.push_back(coarse);
  }
  for (const auto& of : moved) EXPECT_TRUE(of.expired());
}

}  // namespace
}  // namespace isostrata
