// Who may take how much, in numbers: the limit is 1,000 MB.
#include "engine/engine/scene_memory.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

constexpr std::uint64_t kMb = 1'000'000;
constexpr SessionKey kOld = 1, kNew = 2, kOwn = 3, kNobody = 9;
const auto kAll = [](SessionKey) { return true; };
const auto kNone = [](SessionKey) { return false; };

class SceneMemoryTest : public ::testing::Test {
 protected:
  SceneMemoryTest() {
    for (const SessionKey session : {kOld, kNew, kOwn}) {
      memory_.see(session);
      memory_.hold(session, 200 * kMb);
    }
  }
  std::uint64_t elsewhere_ = 100 * kMb;
  SceneMemory memory_{1000 * kMb, [this] { return elsewhere_; }};
};

TEST_F(SceneMemoryTest, FreeIsWhatNeitherDatasetsNorWorksNorScenesHave) {
  EXPECT_EQ(memory_.free(), 300 * kMb);
  EXPECT_EQ(memory_.quarter_of_free(), 75 * kMb);
  EXPECT_TRUE(memory_.begin_work_in_free(250 * kMb));
  EXPECT_EQ(memory_.free(), 50 * kMb);
  EXPECT_FALSE(memory_.begin_work_in_free(51 * kMb));
  EXPECT_EQ(memory_.quarter_of_free(), SceneMemory::kLeastWork);
  memory_.end_work(250 * kMb);
  elsewhere_ = 5000 * kMb;
  EXPECT_EQ(memory_.free(), 0u) << "more than there is is not less than nothing";
}

TEST_F(SceneMemoryTest, AWorkBeginsOnceAsFewScenesAsMustHaveMadeWay) {
  const auto fits = memory_.begin_work(kNobody, 300 * kMb, kAll);
  EXPECT_TRUE(fits.gone.empty());
  EXPECT_TRUE(memory_.any_work());
  memory_.end_work(300 * kMb);
  EXPECT_FALSE(memory_.any_work());

  const auto room = memory_.begin_work(kNobody, 400 * kMb, kAll);
  EXPECT_EQ(room.gone, std::vector<SessionKey>{kOld});
  EXPECT_EQ(room.bytes, 500 * kMb);
  EXPECT_EQ(memory_.free(), 100 * kMb);
}

TEST_F(SceneMemoryTest, AWorkThatFindsTooLittleDoesNotBeginAndIsToldHowMuchThereIs) {
  const auto room = memory_.begin_work(kOwn, 701 * kMb, kAll);
  EXPECT_EQ(room.gone, (std::vector<SessionKey>{kOld, kNew})) << "its own scene stays";
  EXPECT_EQ(room.bytes, 700 * kMb);
  EXPECT_FALSE(memory_.any_work());
  EXPECT_EQ(memory_.begin_work(kOwn, 700 * kMb, kAll).bytes, 700 * kMb);
  EXPECT_TRUE(memory_.any_work());
}

TEST_F(SceneMemoryTest, WhatIsBeingDrawnOrExtractedStays) {
  const auto room = memory_.begin_work(kNobody, 400 * kMb, kNone);
  EXPECT_TRUE(room.gone.empty());
  EXPECT_EQ(room.bytes, 300 * kMb);
  EXPECT_FALSE(memory_.any_work());
}

TEST_F(SceneMemoryTest, WhoIsLookedAtGoesLast) {
  memory_.see(kOld);
  EXPECT_EQ(memory_.begin_work(kNobody, 400 * kMb, kAll).gone, std::vector<SessionKey>{kNew});
}

TEST_F(SceneMemoryTest, ScenesThatAreMadeAtTheSameTimeHaveNoMoreThanThereIsInAll) {
  const auto first = memory_.for_next_scene(kOwn, false, kAll), second = memory_.for_next_scene(kNew, false, kAll),
             third = memory_.for_next_scene(kNobody, false, kAll);
  EXPECT_GT(third.bytes, 0u);
  EXPECT_LE(2 * (first.bytes + second.bytes + third.bytes), 900 * kMb);
  EXPECT_GT(first.bytes, second.bytes);
  EXPECT_FALSE(memory_.leave_most(kNew, kAll)) << "another one is being made, and may take much";
  memory_.end_next_scene(kOwn);
  memory_.end_next_scene(kNobody);
  memory_.hold(kOwn, 300 * kMb);
  EXPECT_TRUE(memory_.leave_most(kNew, kAll));
  EXPECT_FALSE(memory_.leave_most(kNew, kNone)) << "others are at theirs";
  EXPECT_EQ(memory_.altogether(kNew, kAll), 900 * kMb / 2);
  EXPECT_EQ(memory_.altogether(kNew, kNone), (900 - 300) * kMb / 2);
  EXPECT_EQ(memory_.for_next_scene(kNew, true, kAll).bytes, 900 * kMb / 2) << "its own first part is none of others'";
  EXPECT_EQ(memory_.for_next_scene(kOld, true, kAll).bytes, 0u);
}

TEST_F(SceneMemoryTest, WhatTheLastOneTookAndAQuarterMoreIsGivenIfItIsThere) {
  memory_.hold(kOwn, 500 * kMb);
  EXPECT_EQ(memory_.for_next_scene(kOwn, false, kNone).bytes, (900 - 400) * kMb / 2);
  memory_.hold(kOwn, 320 * kMb);
  EXPECT_EQ(memory_.for_next_scene(kOwn, false, kNone).bytes, 400 * kMb / 2);
}

TEST_F(SceneMemoryTest, TheNextSceneHasHalfOfWhatOthersLeaveForARendererMakesAsMuchOfIt) {
  const auto next = memory_.for_next_scene(kOwn, false, kAll);
  EXPECT_EQ(next.gone, std::vector<SessionKey>{kOld}) << "its last one, and another as large, need 400 of 900";
  EXPECT_EQ(next.bytes, (900 - 200) * kMb / 4 * 3 / 2);
  const auto altogether = memory_.for_next_scene(kOwn, true, kAll);
  EXPECT_EQ(altogether.gone, std::vector<SessionKey>{kNew});
  EXPECT_EQ(altogether.bytes, 900 * kMb / 2);
}

TEST_F(SceneMemoryTest, AfterASceneHasGrownOthersGoUntilAllAreWithinTheLimit) {
  EXPECT_TRUE(memory_.make_way_for(kOwn, kAll).empty());
  memory_.hold(kOwn, 600 * kMb);
  EXPECT_EQ(memory_.make_way_for(kOwn, kAll), std::vector<SessionKey>{kOld});
  elsewhere_ = 1000 * kMb;
  EXPECT_EQ(memory_.make_way_for(kOwn, kAll), std::vector<SessionKey>{kNew});
  EXPECT_TRUE(memory_.make_way_for(kOwn, kAll).empty()) << "its own stays, over the limit or not";
}

TEST_F(SceneMemoryTest, AWorkOnLayersThatAreShownMayTakeTwiceWhatTheyDo) {
  EXPECT_EQ(memory_.for_work_on(kOwn), 400 * kMb);
  EXPECT_EQ(memory_.for_work_on(kNobody), SceneMemory::kLeastWork);
  memory_.forget(kOwn);
  EXPECT_EQ(memory_.for_work_on(kOwn), SceneMemory::kLeastWork);
}

}  // namespace
}  // namespace isostrata
