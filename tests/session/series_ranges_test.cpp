// A series' ranges as a session learns them: what is known at once, the rest when all steps have been read.
#include <gtest/gtest.h>

#include "session/fake_engine.h"

namespace isostrata {
namespace {

class RangesInASession : public ::testing::Test, protected SessionsOnAClock {
 protected:
  /// Nothing but zeros at the first step; with `all`, what the others have.
  static DatasetFacts mug(bool all) {
    DatasetFacts facts = SessionsOnAClock::facts("temperature");
    facts.arrays.front().lower = facts.arrays.front().upper = 0;
    facts.arrays.front().steps = {{0, 0}, {}, {}};
    facts.missing_steps = 2;
    facts.arrays.front().unit = "K";
    facts.first_view = {};
    if (!all) return facts;
    facts.arrays.front().upper = 80;
    facts.arrays.front().steps = {{0, 0}, {0, 20}, {5, 80}};
    facts.missing_steps = 0;
    facts.first_view = first_view_of("temperature", {{0, 20}, {20, 40}, {40, 80}}, facts.bounds);
    return facts;
  }
  std::shared_ptr<FakeClient> viewer_of(const DatasetFacts& facts) {
    auto client = connect(looking());
    v1::ClientMessage open;
    open.mutable_open_dataset()->set_id("fin");
    say(*client, open);
    const auto asked = take<OpenRequest>();
    EXPECT_EQ(asked.size(), 1u);
    EXPECT_FALSE(asked.front().all_ranges);
    sessions->on_event(DatasetReady{asked.front().session, asked.front().request, facts}, now);
    return client;
  }
  static v1::DatasetInfo told(const FakeClient& client) {
    return client.outbox.newest([](const auto& m) { return m.has_dataset_info(); }).dataset_info();
  }
  OpenRequest asked_for_all() {
    const auto asked = take<OpenRequest>();
    EXPECT_EQ(asked.size(), 1u);
    if (asked.empty()) return {};
    EXPECT_TRUE(asked.front().all_ranges);
    EXPECT_EQ(asked.front().dataset, "fin");
    return asked.front();
  }
};

TEST_F(RangesInASession, AreToldAgainAndLayersThatNobodyTouchedFollow) {
  const auto client = viewer_of(mug(false));
  EXPECT_EQ(told(*client).missing_range_steps(), 2);
  EXPECT_EQ(told(*client).arrays(0).unit(), "K");
  EXPECT_EQ(client->outbox.state().intervals_size(), 0);
  const OpenRequest request = asked_for_all();
  sessions->on_event(OperationProgress{request.session, 7, "reading", 0.5, request.request}, now);
  EXPECT_TRUE(client->outbox.newest([](const auto& m) { return m.has_progress(); }).progress().purpose() == v1::PURPOSE_RANGES);

  sessions->on_event(DatasetReady{request.session, request.request, mug(true)}, now);
  EXPECT_EQ(told(*client).missing_range_steps(), 0);
  EXPECT_EQ(told(*client).arrays(0).upper(), 80);
  EXPECT_EQ(told(*client).arrays(0).step_upper(1), 20);
  EXPECT_EQ(client->outbox.state().array(), "temperature");
  ASSERT_EQ(client->outbox.state().intervals_size(), 3);
  EXPECT_EQ(client->outbox.state().intervals(2).upper(), 80);
  EXPECT_TRUE(take<OpenRequest>().empty()) << "once is enough";
}

TEST_F(RangesInASession, LayersThatSomebodyTouchedStay) {
  DatasetFacts early = mug(true);
  early.arrays.front().upper = 20;
  early.missing_steps = 1;
  early.first_view = first_view_of("temperature", {{0, 5}, {5, 20}}, early.bounds);
  const auto client = viewer_of(early);
  const OpenRequest request = asked_for_all();
  v1::ClientMessage patch;
  patch.mutable_patch_interval()->set_id(1);
  patch.mutable_patch_interval()->set_opacity(0.875);
  say(*client, patch);
  sessions->on_event(DatasetReady{request.session, request.request, mug(true)}, now);
  EXPECT_EQ(told(*client).missing_range_steps(), 0);
  ASSERT_EQ(client->outbox.state().intervals_size(), 2);
  EXPECT_EQ(client->outbox.state().intervals(1).upper(), 20);
}

TEST_F(RangesInASession, ColoursOverAllStepsAreDrawnAgainWhenMoreIsKnown) {
  DatasetFacts early = mug(true);
  early.arrays.front().upper = 20;
  early.missing_steps = 1;
  const auto client = viewer_of(early);
  const OpenRequest request = asked_for_all();
  v1::ClientMessage look, touch;
  look.mutable_set_appearance()->mutable_color_range()->set_span(v1::COLOR_SPAN_ALL_STEPS);
  touch.mutable_patch_interval()->set_id(1);
  touch.mutable_patch_interval()->set_opacity(0.875);
  say(*client, look);
  say(*client, touch);
  take<SceneUpdate>();
  const auto before = client->outbox.state().revision();
  sessions->on_event(DatasetReady{request.session, request.request, mug(true)}, now);
  const auto updates = take<SceneUpdate>();
  ASSERT_EQ(updates.size(), 1u);
  EXPECT_EQ(updates.front().scene.color_range.upper, 80);
  EXPECT_EQ(updates.front().scene.revision, before + 1);
  EXPECT_EQ(client->outbox.state().revision(), before + 1);
}

TEST_F(RangesInASession, LayersKeepTheirIdsWhenTheyFollow) {
  DatasetFacts early = mug(true);
  early.missing_steps = 1;
  early.first_view = first_view_of("temperature", {{0, 5}, {5, 20}}, early.bounds);
  const auto client = viewer_of(early);
  const auto before = client->outbox.state();
  const OpenRequest request = asked_for_all();
  sessions->on_event(DatasetReady{request.session, request.request, mug(true)}, now);
  const auto after = client->outbox.state();
  ASSERT_EQ(after.intervals_size(), 3);
  EXPECT_EQ(after.intervals(0).id(), before.intervals(0).id());
  EXPECT_EQ(after.intervals(1).id(), before.intervals(1).id());
  EXPECT_GT(after.intervals(2).id(), before.intervals(1).id());
  EXPECT_GT(after.revision(), before.revision());
}

TEST_F(RangesInASession, WhatIsKnownStaysWhenTheReadingIsCancelled) {
  const auto client = viewer_of(mug(false));
  const OpenRequest request = asked_for_all();
  sessions->on_event(RequestFailed{request.session, request.request, 0, ErrorCode::cancelled, "cancelled"}, now);
  EXPECT_EQ(told(*client).missing_range_steps(), 2);
  EXPECT_TRUE(client->outbox.error().code().empty());
  EXPECT_TRUE(take<OpenRequest>().empty());
}

TEST_F(RangesInASession, AnotherDatasetEndsTheReading) {
  const auto client = viewer_of(mug(false));
  const OpenRequest request = asked_for_all();
  v1::ClientMessage open;
  open.mutable_open_dataset()->set_id("other");
  say(*client, open);
  const auto asked = take<OpenRequest>();
  ASSERT_EQ(asked.size(), 1u);
  DatasetFacts other = facts();
  other.id = "other";
  sessions->on_event(DatasetReady{asked.front().session, asked.front().request, other}, now);
  const auto cancelled = take<CancelRequest>();
  ASSERT_EQ(cancelled.size(), 1u);
  EXPECT_EQ(cancelled.front().request, request.request);
  sessions->on_event(DatasetReady{request.session, request.request, mug(true)}, now);
  EXPECT_EQ(told(*client).id(), "other");
}

TEST_F(RangesInASession, AHistogramIsAskedForOverAllSteps) {
  const auto client = viewer_of(mug(true));
  v1::ClientMessage ask;
  ask.mutable_request_histogram()->set_array("temperature");
  ask.mutable_request_histogram()->set_bins(4);
  say(*client, ask);
  const auto asked = take<HistogramRequest>();
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_EQ(asked.front().least, (ValueRange{0, 80}));
}

}  // namespace
}  // namespace isostrata
