// Who may do what to whom, without a session, an engine or a clock that runs.
#include "session/people/participants.h"

#include <gtest/gtest.h>

#include "session/fake_engine.h"
#include "session/people_messages.h"

namespace isostrata {
namespace {

class ParticipantsOfASession : public ::testing::Test {
 protected:
  struct Person {
    FakeOutbox outbox;
    Viewer viewer;
  };
  Person& come(ViewerKey key, v1::Role role = v1::ROLE_CONTROLLER, const std::string& invitation = {}) {
    Person& person = people_here_[key];
    person.viewer.key = key;
    person.viewer.outbox = &person.outbox;
    person.viewer.role = role;
    person.viewer.invitation = invitation;
    person.viewer.client_id = "client of " + std::to_string(key);
    people_.add(person.viewer);
    return person;
  }
  /// What it says of the message; "": it was done.
  std::string say(Person& person, const v1::ClientMessage& message) {
    if (const auto why = people_.forbidden(person.viewer, message)) return "forbidden";
    std::string code;
    if (!people_.answer(person.viewer, message, kNow, [&](std::optional<v1::Error> error) { code = error ? error->code() : ""; })) return "not about people";
    return code;
  }
  /// By somebody with the server's token, or by who came by `made_by`.
  std::string invitation(v1::Role role, const std::string& made_by = {}) {
    v1::CreateInvitation wanted;
    wanted.set_role(role);
    const auto made = people_.invite(wanted, made_by);
    return made.error ? made.error->code() : made.invitation->id;
  }

  static constexpr TimePoint kNow{std::chrono::hours(1)};
  int told_ = 0, kept_ = 0;
  std::vector<std::string> ended_;
  std::map<ViewerKey, Person> people_here_;
  Participants people_{{.people_changed = [this] { ++told_; },
                        .kept_changed = [this] { ++kept_; },
                        .invitation_ended = [this](const std::string& id) {
                          EXPECT_GT(kept_, 0) << "what is over is kept before anybody is cut off";
                          ended_.push_back(id);
                        }}};
};

TEST_F(ParticipantsOfASession, ASessionAlwaysHasAController) {
  Person& one = come(1);
  EXPECT_EQ(say(one, role_of(0, v1::ROLE_VIEWER)), "invalid_argument");
  Person& two = come(2, v1::ROLE_VIEWER);
  EXPECT_EQ(say(two, role_of(1, v1::ROLE_VIEWER)), "forbidden");
  EXPECT_EQ(say(one, role_of(2, v1::ROLE_CONTROLLER)), "");
  EXPECT_EQ(say(one, role_of(0, v1::ROLE_VIEWER)), "");
  EXPECT_EQ(one.viewer.role, v1::ROLE_VIEWER);
  EXPECT_EQ(told_, 2);
  ASSERT_EQ(two.outbox.participants().participants_size(), 2);
  EXPECT_EQ(two.outbox.participants().participants(0).role(), v1::ROLE_VIEWER);
  EXPECT_EQ(say(one, role_of(0, v1::ROLE_CONTROLLER)), "") << "who has the server's token takes it back";
  EXPECT_EQ(say(one, role_of(3, v1::ROLE_VIEWER)), "not_found");
  EXPECT_EQ(say(one, role_of(1, v1::ROLE_CONTROLLER)), "") << "as it is";
  EXPECT_EQ(told_, 3) << "which nobody but who asked is told";
}

TEST_F(ParticipantsOfASession, WhoMayOnlyLookChangesNothingThatOthersSee) {
  come(1);
  Person& viewer = come(2, v1::ROLE_VIEWER, invitation(v1::ROLE_VIEWER));
  v1::ClientMessage open, camera, list, viewport;
  open.mutable_open_dataset();
  camera.mutable_set_camera();
  list.mutable_list_invitations();
  viewport.mutable_viewport();
  for (const auto& message : {open, camera, list, invite(v1::ROLE_VIEWER), revoke("x"), role_of(0, v1::ROLE_CONTROLLER)})
    EXPECT_EQ(say(viewer, message), "forbidden") << message.DebugString();
  EXPECT_EQ(say(viewer, viewport), "not about people");
}

TEST_F(ParticipantsOfASession, AGuestActsOnItsOwnGuestsAlone) {
  Person& owner = come(1);
  const std::string first = invitation(v1::ROLE_CONTROLLER), other = invitation(v1::ROLE_VIEWER);
  Person& guest = come(2, v1::ROLE_CONTROLLER, first);
  const std::string second = invitation(v1::ROLE_VIEWER, first), third = invitation(v1::ROLE_VIEWER, second);
  come(3, v1::ROLE_VIEWER, other);
  come(4, v1::ROLE_VIEWER, second);
  come(5, v1::ROLE_VIEWER, third);
  EXPECT_EQ(say(guest, role_of(1, v1::ROLE_VIEWER)), "forbidden");
  EXPECT_EQ(say(guest, role_of(3, v1::ROLE_CONTROLLER)), "forbidden");
  EXPECT_EQ(say(guest, role_of(4, v1::ROLE_CONTROLLER)), "");
  EXPECT_EQ(say(guest, role_of(5, v1::ROLE_CONTROLLER)), "") << "its guest's guest";
  EXPECT_EQ(say(guest, revoke(other)), "forbidden");
  EXPECT_EQ(say(guest, revoke(first)), "forbidden") << "its own way in is not its to close";
  v1::ClientMessage list;
  list.mutable_list_invitations();
  EXPECT_EQ(say(guest, list), "");
  EXPECT_EQ(guest.outbox.messages.back().invitations().invitations_size(), 2);
  EXPECT_EQ(say(owner, list), "");
  EXPECT_EQ(owner.outbox.messages.back().invitations().invitations_size(), 4);
  EXPECT_EQ(owner.outbox.messages.back().invitations().invitations(2).present(), 1u);
}

TEST_F(ParticipantsOfASession, AnInvitationThatIsOverTakesAlongWhatCameOfIt) {
  Person& owner = come(1);
  const std::string first = invitation(v1::ROLE_CONTROLLER), second = invitation(v1::ROLE_VIEWER, first), other = invitation(v1::ROLE_VIEWER);
  EXPECT_EQ(kept_, 3);
  EXPECT_EQ(say(owner, revoke(first)), "");
  EXPECT_EQ(ended_, (std::vector{first, second}));
  EXPECT_EQ(say(owner, revoke(first)), "not_found");
  people_.expire(unix_ms_now());
  EXPECT_EQ(kept_, 4);
  people_.expire(unix_ms_now() + static_cast<UnixMs>(1000 * Invitations::kDefaultSeconds) + 1000);
  EXPECT_EQ(ended_.back(), other);
  EXPECT_EQ(kept_, 5);
  EXPECT_TRUE(people_.invitations().all().empty());
}

TEST_F(ParticipantsOfASession, AnInvitationsTokenIsToldOnceToWhoMadeIt) {
  Person& owner = come(1);
  Person& other = come(2);
  EXPECT_EQ(say(owner, invite(v1::ROLE_VIEWER)), "");
  EXPECT_FALSE(owner.outbox.messages.back().invitation().token().empty());
  EXPECT_TRUE(other.outbox.messages.empty());
  EXPECT_EQ(say(owner, invite(v1::ROLE_UNSPECIFIED)), "invalid_argument");
}

TEST_F(ParticipantsOfASession, WhoMayOnlyLookHasSmallerPicturesFromThatMomentOn) {
  Person& owner = come(1);
  Person& other = come(2);
  v1::Viewport wall;
  wall.set_width(16000);
  wall.set_height(4000);
  other.viewer.set_viewport(wall, kNow);
  EXPECT_EQ(other.viewer.frames.width(), 16000);
  EXPECT_EQ(say(owner, role_of(2, v1::ROLE_VIEWER)), "");
  EXPECT_LE(static_cast<std::int64_t>(other.viewer.frames.width()) * other.viewer.frames.height(), kMaxViewerPixels);
  EXPECT_NEAR(other.viewer.frames.aspect(), 4, 0.01);
  other.viewer.server_pixels = 10'000;
  other.viewer.set_viewport(wall, kNow);
  EXPECT_EQ(other.viewer.frames.width(), 200);
  EXPECT_EQ(other.viewer.frames.height(), 50);
  EXPECT_EQ(say(owner, role_of(2, v1::ROLE_CONTROLLER)), "");
  EXPECT_EQ(other.viewer.frames.width(), 16000) << "as it was asked for";
}

TEST_F(ParticipantsOfASession, AControllerSaysHowLargeThePicturesOfThoseWhoOnlyLookAre) {
  Person& owner = come(1);
  Person& other = come(2, v1::ROLE_VIEWER);
  v1::Viewport window;
  window.set_width(2000);
  window.set_height(1000);
  for (Person* const one : {&owner, &other}) one->viewer.set_viewport(window, kNow);
  EXPECT_EQ(say(owner, viewer_size(400, 200)), "");
  EXPECT_EQ(kept_, 1);
  EXPECT_EQ(other.viewer.frames.width(), 400);
  EXPECT_EQ(other.viewer.frames.height(), 200);
  EXPECT_EQ(owner.viewer.frames.width(), 2000);
  EXPECT_EQ(other.outbox.participants().viewer_width(), 400u);
  EXPECT_EQ(other.outbox.participants().viewer_height(), 200u);
  v1::RequestStill still;
  still.set_width(401);
  still.set_height(200);
  EXPECT_EQ(other.viewer.refuse_still(still, kNow)->code(), "too_large");
  Person& late = come(3, v1::ROLE_VIEWER);
  late.viewer.set_viewport(window, kNow);
  EXPECT_EQ(late.viewer.frames.width(), 400);
  EXPECT_EQ(say(owner, viewer_size(16384, 16384)), "");
  EXPECT_EQ(other.viewer.most_pixels(), kMaxViewerPixels) << "never more than the server allows";
  EXPECT_EQ(say(owner, viewer_size(0, 0)), "");
  EXPECT_EQ(other.viewer.frames.width(), 2000);
  for (const auto& wrong : {viewer_size(640, 0), viewer_size(0, 360), viewer_size(63, 64), viewer_size(64, 16385)})
    EXPECT_EQ(say(owner, wrong), "invalid_argument") << wrong.ShortDebugString();
  EXPECT_EQ(say(other, viewer_size(0, 0)), "forbidden");
  EXPECT_EQ(say(come(4, v1::ROLE_CONTROLLER, invitation(v1::ROLE_CONTROLLER)), viewer_size(0, 0)), "forbidden");
}

TEST_F(ParticipantsOfASession, AClientIsFoundOnItsNewestConnection) {
  come(1).viewer.client_id = "page";
  come(2).viewer.client_id = "page";
  come(3).viewer.client_id = "";
  EXPECT_EQ(people_.find_client("page")->key, 2u);
  people_.remove(people_here_[2].viewer);
  EXPECT_EQ(people_.find_client("page")->key, 1u);
  EXPECT_EQ(people_.find_client(""), nullptr) << "who says no name is nobody's";
  EXPECT_EQ(people_.find(2), nullptr);
  EXPECT_EQ(people_.size(), 2u);
}

}  // namespace
}  // namespace isostrata
