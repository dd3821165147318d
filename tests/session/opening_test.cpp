// Where a session stands when its dataset has just been opened, and after Reset.
#include <gtest/gtest.h>

#include "session/fake_engine.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

class Opening : public ::testing::Test, protected SessionsOnAClock {
 protected:
  static v1::ClientMessage opened() {
    v1::ClientMessage message;
    message.mutable_open_dataset()->set_id("fin");
    return message;
  }
  static v1::ClientMessage view(const std::string& side) {
    v1::ClientMessage message;
    message.mutable_set_view()->set_view(side);
    return message;
  }
  static v1::ClientMessage window(int width, int height) {
    v1::ClientMessage message;
    message.mutable_viewport()->set_width(static_cast<std::uint32_t>(width));
    message.mutable_viewport()->set_height(static_cast<std::uint32_t>(height));
    return message;
  }
  static std::string text(const v1::Camera& camera) { return camera.ShortDebugString(); }
  /// Of a client who has this window, or none.
  std::string camera_of(const v1::Hello& hello) {
    const auto client = connect(hello);
    say(*client, opened());
    open();
    return text(client->outbox.state().camera());
  }
  static std::string chosen(double aspect) { return text(to_wire(facts().first_view.camera(aspect))); }
};

TEST_F(Opening, TheCameraIsTheSameForEveryWindowAtLeastAsWideAsHighAndForNone) {
  for (const v1::Hello& hello : {v1::Hello{}, looking(64, 64), looking(64, 48), looking(1920, 800)})
    EXPECT_EQ(camera_of(hello), chosen(1));
}

TEST_F(Opening, FromANarrowWindowTheCameraIsFartherAwaySoThatAllIsInIt) {
  EXPECT_EQ(camera_of(looking(40, 80)), chosen(0.5));
  const FirstView view = facts().first_view;
  EXPECT_GT(length(view.camera(0.5).eye - view.camera(0.5).at), length(view.camera(1).eye - view.camera(1).at));
}

TEST_F(Opening, TheCameraDoesNotDependOnHowLongOpeningTakes) {
  const auto client = connect();
  say(*client, opened());
  say(*client, window(40, 80));
  open();
  EXPECT_EQ(text(client->outbox.state().camera()), chosen(1));
}

TEST_F(Opening, ResetGoesBackToWhereOneBeganAndLeavesTheProjection) {
  const auto client = connect(looking(64, 48));
  say(*client, opened());
  open();
  say(*client, view("+x"));
  EXPECT_NE(text(client->outbox.state().camera()), chosen(1));
  say(*client, view("reset"));
  EXPECT_EQ(text(client->outbox.state().camera()), chosen(1));
  v1::ClientMessage parallel = camera(3);
  parallel.mutable_set_camera()->mutable_camera()->set_orthographic(true);
  say(*client, std::move(parallel));
  say(*client, view("reset"));
  v1::Camera begun = to_wire(facts().first_view.camera(1));
  begun.set_orthographic(true);
  EXPECT_EQ(text(client->outbox.state().camera()), text(begun));
}

TEST_F(Opening, WhatStandsUprightAtFirstDoesSoFromEverySide) {
  for (const double upright : {1.0, -1.0}) {
    const auto client = connect(looking(64, 48));
    say(*client, opened());
    for (const OpenRequest& request : take<OpenRequest>()) {
      DatasetFacts scan = facts();
      scan.first_view.up = {0, 0, upright};
      scan.first_view.direction = {0, 1, 0};
      sessions->on_event(DatasetReady{request.session, request.request, scan}, now);
    }
    for (const char* side : {"+x", "-x", "+y", "-y"}) {
      say(*client, view(side));
      EXPECT_EQ(client->outbox.state().camera().up().z(), upright) << side;
    }
    for (const char* side : {"+z", "-z"}) {
      say(*client, view(side));
      EXPECT_EQ(client->outbox.state().camera().up().y(), 1) << side;
    }
  }
}

TEST_F(Opening, OfADatasetThatHasNothingToShowEveryoneIsToldWhy) {
  const auto client = connect(looking());
  say(*client, opened());
  for (const OpenRequest& request : take<OpenRequest>()) {
    DatasetFacts constant = facts();
    constant.first_view = {};
    constant.first_view.array_reason = "every array has one value everywhere";
    sessions->on_event(DatasetReady{request.session, request.request, constant}, now);
  }
  const auto told = client->outbox.newest([](const auto& m) { return m.has_dataset_info(); }).dataset_info();
  EXPECT_EQ(told.nothing_to_show(), "every array has one value everywhere");
  EXPECT_EQ(client->outbox.state().intervals_size(), 0);
  EXPECT_EQ(to_wire(facts()).nothing_to_show(), "");
}

class OpeningAFolder : public ::testing::Test, protected SessionsOnAClock {
 protected:
  OpeningAFolder() {
    std::vector<CatalogueEntry> entries;
    for (int i = 0; i < 20; ++i) entries.push_back({.id = "file " + std::to_string(i), .name = "file", .source = "file " + std::to_string(i)});
    sessions->set_catalogue(std::make_shared<Catalogue>(Catalogue::from_entries(std::move(entries))), "", now);
  }
  /// What is asked to be opened, after the engine has refused it.
  std::string refuse() {
    const auto asked = take<OpenRequest>();
    if (asked.size() != 1) return "";
    sessions->on_event(RequestFailed{asked[0].session, asked[0].request, 0, ErrorCode::bad_data, asked[0].dataset + ": is broken"}, now);
    return asked[0].dataset;
  }
};

TEST_F(OpeningAFolder, TheFirstFileThatShowsSomethingIsShown) {
  const auto client = connect(looking());
  EXPECT_EQ(refuse(), "file 0");
  EXPECT_EQ(client->outbox.error().message(), "file 0: is broken");
  EXPECT_EQ(refuse(), "file 1");
  for (const bool something : {false, true}) {
    const auto asked = take<OpenRequest>();
    ASSERT_EQ(asked.size(), 1u);
    EXPECT_EQ(asked[0].dataset, something ? "file 3" : "file 2");
    DatasetFacts of = facts();
    if (!something) of.first_view = {};
    sessions->on_event(DatasetReady{asked[0].session, asked[0].request, of}, now);
  }
  EXPECT_EQ(client->outbox.state().intervals_size(), 3);
  EXPECT_TRUE(take<OpenRequest>().empty());
}

TEST_F(OpeningAFolder, OfNothingButBrokenFilesEightAreTried) {
  const auto client = connect(looking());
  for (int i = 0; i < 8; ++i) EXPECT_EQ(refuse(), "file " + std::to_string(i));
  EXPECT_EQ(refuse(), "");
}

TEST_F(OpeningAFolder, WhoChoosesMeanwhileHasTheLastWord) {
  const auto client = connect(looking());
  v1::ClientMessage chosen;
  chosen.mutable_open_dataset()->set_id("file 9");
  say(*client, std::move(chosen));
  for (const OpenRequest& asked : take<OpenRequest>())
    sessions->on_event(RequestFailed{asked.session, asked.request, 0, ErrorCode::bad_data, asked.dataset + ": is broken"}, now);
  EXPECT_TRUE(take<OpenRequest>().empty()) << "nothing is opened in place of what somebody chose";
}

}  // namespace
}  // namespace isostrata
