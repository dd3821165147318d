#include "session/sessions/viewer_answers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "session/asked_engine.h"
#include "session/fake_engine.h"

namespace isostrata {
namespace {

class AnswersForOneViewer : public ::testing::Test {
 protected:
  AnswersForOneViewer() {
    for (ViewerKey key : {1, 2}) {
      viewers_[key].key = key;
      viewers_[key].outbox = &outboxes_[key];
      people_.add(viewers_[key]);
    }
  }
  void draw(ViewerKey key, std::uint64_t seq, std::uint32_t width = 100) {
    v1::RequestStill still;
    still.set_width(width);
    still.set_height(width);
    answers_.draw(viewers_[key], still, seq);
  }

  AskedEngine engine_;
  std::map<ViewerKey, Viewer> viewers_;
  std::map<ViewerKey, FakeOutbox> outboxes_;
  Participants people_{{}};
  ViewerAnswers answers_{7, engine_, people_};
};

TEST_F(AnswersForOneViewer, APictureGoesToWhoAskedForItAndSaysWhatItAnswers) {
  draw(1, 17);
  FrameReady ready{7, 1};
  ready.bytes = std::make_shared<const Bytes>(3, std::uint8_t{7});
  engine_.answer(1, ready);
  ASSERT_EQ(outboxes_[1].frames.size(), 1u);
  EXPECT_EQ(outboxes_[1].frames[0].in_reply_to(), 17u);
  EXPECT_EQ(outboxes_[1].payloads[0], ready.bytes);
  EXPECT_TRUE(outboxes_[2].frames.empty());
  EXPECT_EQ(std::get<FrameRequest>(engine_.asked[0]).still, StillFormat::png);
}

TEST_F(AnswersForOneViewer, AFailureIsAnAnswer) {
  draw(1, 17);
  engine_.answer(1, RequestFailed{7, 1, 0, ErrorCode::bad_data, "truncated"});
  EXPECT_EQ(outboxes_[1].error().in_reply_to(), 17u);
  EXPECT_EQ(outboxes_[1].error().message(), "truncated");
  answers_.count(viewers_[2], {}, 18);
  engine_.answer(2, RequestFailed{7, 2, 0, ErrorCode::bad_data, "truncated"});
  EXPECT_EQ(outboxes_[2].error().in_reply_to(), 18u);
}

TEST_F(AnswersForOneViewer, EachHasAFewPicturesAtOnceAndOthersAreNoneOfItsBusiness) {
  for (std::size_t i = 0; i < ViewerAnswers::kMostPictures; ++i) draw(1, i + 1);
  draw(1, 9);
  EXPECT_EQ(outboxes_[1].error().code(), "unavailable");
  EXPECT_EQ(outboxes_[1].error().in_reply_to(), 9u);
  draw(2, 1);
  EXPECT_TRUE(outboxes_[2].messages.empty());
  engine_.answer(1, RequestFailed{7, 1});
  const std::size_t before = engine_.asked.size();
  draw(1, 10);
  EXPECT_EQ(engine_.asked.size(), before + 1);
}

TEST_F(AnswersForOneViewer, WithoutASizeThePictureIsAsLargeAsTheViewport) {
  draw(1, 1, 0);
  EXPECT_EQ(outboxes_[1].error().code(), "invalid_argument") << "there is no viewport";
  viewers_[1].frames.set_viewport(640, 480, false, {});
  draw(1, 2, 0);
  EXPECT_EQ(std::get<FrameRequest>(engine_.asked.back()).width, 640);
  EXPECT_EQ(std::get<FrameRequest>(engine_.asked.back()).height, 480);
}

TEST_F(AnswersForOneViewer, ANewerProbeTakesThePlaceOfTheOneBefore) {
  answers_.probe(viewers_[1], ProbeRequest{}, 5);
  answers_.probe(viewers_[2], ProbeRequest{}, 6);
  answers_.probe(viewers_[1], ProbeRequest{}, 7);
  EXPECT_EQ(outboxes_[1].error().code(), "cancelled");
  EXPECT_EQ(outboxes_[1].error().in_reply_to(), 5u);
  ASSERT_EQ(engine_.posted.size(), 1u);
  EXPECT_EQ(std::get<CancelRequest>(engine_.posted[0]).request, 1u);
  EXPECT_TRUE(outboxes_[2].messages.empty()) << "another's probe is none of its business";
  ProbeReady ready{7, 3, 42, {}};
  ready.facts.hit = true;
  ready.facts.arrays = {{"a", 1.5, {}}, {"b", {}, 2.0}};
  engine_.answer(3, ready);
  const v1::ProbeResult& told = outboxes_[1].messages.back().probe_result();
  EXPECT_EQ(told.in_reply_to(), 7u);
  EXPECT_EQ(told.revision(), 42u);
  EXPECT_FALSE(told.has_cell());
  EXPECT_EQ(told.arrays(0).value(), 1.5);
  EXPECT_FALSE(told.arrays(1).has_value());
  EXPECT_EQ(told.arrays(1).cell_value(), 2.0);
  answers_.probe(viewers_[1], ProbeRequest{}, 8);
  EXPECT_EQ(engine_.posted.size(), 1u) << "nothing to give up";
  answers_.leave(1);
  EXPECT_EQ(std::get<CancelRequest>(engine_.posted[1]).request, 4u);
}

TEST_F(AnswersForOneViewer, ALineAndAPlaceOverStepsDoNotTakeEachOthersPlace) {
  CurveRequest line, place;
  line.to = Vec3d{1, 0, 0};
  answers_.probe(viewers_[1], ProbeRequest{}, 4);
  answers_.probe(viewers_[1], line, 5);
  answers_.probe(viewers_[1], place, 6);
  EXPECT_TRUE(outboxes_[1].messages.empty());
  answers_.probe(viewers_[1], line, 7);
  EXPECT_EQ(outboxes_[1].error().code(), "cancelled");
  EXPECT_EQ(outboxes_[1].error().in_reply_to(), 5u);
  engine_.answer(4, CurveReady{7, 4, 42, {"f", {0, 1}, {2, NAN}, true, {{0, 0.5, 9, -1}, {0.5, 1, 0, 2}}, 3, {}}});
  const v1::ProbedCurve told = outboxes_[1].messages.back().probed_curve();
  EXPECT_EQ(told.in_reply_to(), 7u);
  EXPECT_EQ(told.revision(), 42u);
  EXPECT_EQ(told.value(0), 2);
  EXPECT_TRUE(std::isnan(told.value(1)));
  EXPECT_EQ(told.layers(0).interval(), 9u);
  EXPECT_FALSE(told.layers(0).has_term());
  EXPECT_EQ(told.layers(1).term(), 2);
  answers_.give_up_steps(viewers_[1].key);
  EXPECT_EQ(outboxes_[1].error().in_reply_to(), 6u);
  EXPECT_EQ(std::get<CancelRequest>(engine_.posted.back()).request, 3u);
  answers_.give_up_steps(viewers_[1].key);
  EXPECT_EQ(engine_.posted.size(), 2u) << "nothing is left to give up";
}

TEST_F(AnswersForOneViewer, WhoIsGoneHasNothingDrawn) {
  draw(1, 1);
  draw(2, 1);
  answers_.leave(1);
  ASSERT_EQ(engine_.posted.size(), 1u);
  EXPECT_EQ(std::get<ForgetFrame>(engine_.posted[0]).request, 1u);
  EXPECT_FALSE(engine_.listeners.contains(1));
  EXPECT_TRUE(engine_.listeners.contains(2));
  answers_.leave(1);
  EXPECT_EQ(engine_.posted.size(), 1u);
}

TEST_F(AnswersForOneViewer, HistogramsAreFewOfAllTogetherAlsoOfThoseWhoLeft) {
  for (int i = 0; i < ViewerAnswers::kMostHistograms; ++i) answers_.count(viewers_[1], {}, static_cast<std::uint64_t>(i) + 1);
  answers_.count(viewers_[2], {}, 1);
  EXPECT_EQ(outboxes_[2].error().code(), "unavailable");
  people_.remove(viewers_[1]);
  engine_.answer(1, HistogramReady{7, 1});
  const std::size_t before = engine_.asked.size();
  answers_.count(viewers_[2], {}, 2);
  EXPECT_EQ(engine_.asked.size(), before + 1);
  engine_.answer(engine_.last, HistogramReady{7, engine_.last});
  EXPECT_TRUE(outboxes_[2].messages.back().has_histogram());
}

}  // namespace
}  // namespace isostrata
