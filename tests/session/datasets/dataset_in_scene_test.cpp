#include "session/datasets/dataset_in_scene.h"

#include <gtest/gtest.h>

#include "session/wire/wire.h"
#include "support/fin_facts.h"

namespace isostrata {
namespace {

class DatasetInTheScene : public ::testing::Test {
 protected:
  static DatasetFacts fin(const std::string& array = "Density", double upper = 8) {
    DatasetFacts facts;
    facts.id = facts.name = "fin";
    facts.bounds.include({-1, -1, -1});
    facts.bounds.include({1, 2, 3});
    facts.arrays = {{array, "point", "float32", 1, 0, upper, 0}};
    facts.first_view = first_view_of(array, {{0, 2}, {2, 4}, {4, upper}}, facts.bounds);
    facts.times = {0, 1, 2};
    return facts;
  }
  std::string wire() const { return to_wire(state_.scene).SerializeAsString(); }

  SceneState state_;
  DatasetInScene scene_{state_};
};

TEST_F(DatasetInTheScene, IsShownByItsFirstLook) {
  const auto shown = scene_.show(fin(), false, 1, false);
  EXPECT_TRUE(shown.changed);
  EXPECT_FALSE(shown.woken);
  EXPECT_FALSE(shown.error);
  EXPECT_EQ(state_.scene.dataset, "fin");
  EXPECT_EQ(state_.scene.intervals.size(), 3u);
}

TEST_F(DatasetInTheScene, GoesOnWithWhatFitsAfterItWasReadAgain) {
  scene_.show(fin(), false, 1, false);
  state_.scene.step = 2;
  state_.scene.intervals.pop_back();
  const std::uint64_t revision = state_.scene.revision;
  DatasetFacts shorter = fin();
  shorter.times = {0, 1};
  const auto shown = scene_.show(shorter, true, 1, false);
  EXPECT_TRUE(shown.changed);
  EXPECT_FALSE(shown.error);
  EXPECT_EQ(state_.scene.step, 1) << "the last that is there";
  EXPECT_EQ(state_.scene.intervals.size(), 2u);
  EXPECT_EQ(state_.scene.revision, revision + 1) << "another picture, of the same scene";
}

TEST_F(DatasetInTheScene, BeginsAnewWhereItIsAnotherOneUnderTheSameName) {
  scene_.show(fin(), false, 1, false);
  const std::uint64_t revision = state_.scene.revision;
  const auto shown = scene_.show(fin("Pressure"), true, 1, false);
  ASSERT_TRUE(shown.error);
  EXPECT_EQ(shown.error->code(), "bad_data");
  EXPECT_EQ(state_.scene.array, "Pressure");
  EXPECT_EQ(state_.scene.revision, revision + 1);
}

TEST_F(DatasetInTheScene, SleepsAsItWasKeptAndWakesTheSame) {
  scene_.show(fin(), false, 1, false);
  state_.scene.intervals[1].name = "mine";
  const v1::State kept = to_wire(state_.scene);
  SceneState later;
  DatasetInScene next(later);
  next.restore(kept, state_.last_interval_id);
  ASSERT_NE(next.asleep(), nullptr);
  EXPECT_EQ(next.asleep()->SerializeAsString(), kept.SerializeAsString());
  EXPECT_EQ(later.scene.dataset, "fin");
  EXPECT_EQ(later.scene.revision, kept.revision());
  const auto shown = next.show(fin(), false, 1, false);
  EXPECT_TRUE(shown.woken);
  EXPECT_FALSE(shown.changed) << "everyone has been told this state";
  EXPECT_EQ(next.asleep(), nullptr);
  EXPECT_EQ(to_wire(later.scene).SerializeAsString(), kept.SerializeAsString());
  EXPECT_EQ(later.last_interval_id, state_.last_interval_id);
}

TEST_F(DatasetInTheScene, WakesToAFirstLookWhereWhatWasKeptDoesNotFit) {
  scene_.show(fin(), false, 1, false);
  SceneState later;
  DatasetInScene next(later);
  next.restore(to_wire(state_.scene), state_.last_interval_id);
  const auto shown = next.show(fin("Pressure"), false, 1, false);
  EXPECT_TRUE(shown.woken);
  EXPECT_TRUE(shown.changed);
  ASSERT_TRUE(shown.error);
  EXPECT_NE(shown.error->message().find("when this session was kept"), std::string::npos);
  EXPECT_EQ(later.scene.array, "Pressure");
}

TEST_F(DatasetInTheScene, WhatSleptIsForgottenWhenAnotherDatasetIsOpened) {
  v1::State kept;
  kept.set_dataset("other");
  kept.set_revision(9);
  scene_.restore(kept, 4);
  const auto shown = scene_.show(fin(), false, 1, false);
  EXPECT_FALSE(shown.woken);
  EXPECT_TRUE(shown.changed);
  EXPECT_EQ(scene_.asleep(), nullptr);
  EXPECT_GT(state_.scene.revision, 9u);
}

TEST_F(DatasetInTheScene, WithoutADatasetNothingSleeps) {
  v1::State kept;
  kept.mutable_background()->set_g(0.5F);
  scene_.restore(kept, 0);
  EXPECT_EQ(scene_.asleep(), nullptr);
  EXPECT_EQ(state_.scene.revision, 1u) << "there is no revision 0";
}

TEST_F(DatasetInTheScene, LayersThatNobodyTouchedFollowTheRangesThatAreLearned) {
  const DatasetFacts before = fin("Density", 8), now = fin("Density", 80);
  scene_.show(before, false, 1, true);
  const std::uint64_t revision = state_.scene.revision;
  EXPECT_TRUE(scene_.ranges_read(&before, now));
  EXPECT_EQ(state_.scene.intervals.back().upper, 80);
  EXPECT_GT(state_.scene.revision, revision);
}

TEST_F(DatasetInTheScene, LayersThatSomebodyTouchedStayAndTheirColoursAlone) {
  const DatasetFacts before = fin("Density", 8), now = fin("Density", 80);
  scene_.show(before, false, 1, true);
  state_.scene.intervals.pop_back();
  state_.scene.color_range.span = ColorSpan::all_steps;
  const std::uint64_t revision = state_.scene.revision;
  EXPECT_TRUE(scene_.ranges_read(&before, now)) << "the colours run over all steps";
  EXPECT_EQ(state_.scene.intervals.size(), 2u);
  EXPECT_EQ(state_.scene.revision, revision + 1);
  EXPECT_FALSE(scene_.ranges_read(&now, now)) << "nothing is new";
  EXPECT_EQ(state_.scene.revision, revision + 1);
}

TEST_F(DatasetInTheScene, RangesThatDoNotComeChangeNothingNorDoThoseThatComeLater) {
  const DatasetFacts before = fin("Density", 8), now = fin("Density", 80);
  scene_.show(before, false, 1, true);
  const std::string shown = wire();
  EXPECT_FALSE(scene_.ranges_read(nullptr, before));
  EXPECT_EQ(wire(), shown);
  scene_.ranges_read(&before, now);
  EXPECT_EQ(state_.scene.intervals.back().upper, 8) << "the first look is over";
}

}  // namespace
}  // namespace isostrata
