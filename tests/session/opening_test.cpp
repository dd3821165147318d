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

}  // namespace
}  // namespace isostrata
