// What those who were invited may not do to others: to who has the server's token, and to each other.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "session/people_messages.h"
#include "session/sessions/sessions_observer.h"
#include "session/wire/random_token.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

class Roles : public ::testing::Test {
 protected:
  Roles() {
    owner_ = s_.connect(s_.looking());
    s_.open();
  }
  /// Invites by `host`, and comes by it; `made` is the invitation.
  std::shared_ptr<FakeClient> guest(FakeClient& host, v1::Role role, v1::Invitation& made, double seconds = 0,
                                    v1::Hello hello = SessionsOnAClock::looking()) {
    s_.say(host, invite(role, seconds));
    made = invitation_of(host);
    const auto admission = s_.sessions->admit(made.token());
    EXPECT_TRUE(admission);
    return s_.connect(std::move(hello), admission.value_or(Sessions::Admission{}));
  }
  std::string refusal(FakeClient& client, const v1::ClientMessage& message) {
    const auto before = client.outbox.messages.size();
    s_.say(client, message);
    for (std::size_t i = before; i < client.outbox.messages.size(); ++i)
      if (client.outbox.messages[i].has_error()) return client.outbox.messages[i].error().code();
    return "";
  }
  v1::Role role_now(const FakeClient& of) {
    const v1::Participants all = owner_->outbox.participants();
    for (const auto& one : all.participants())
      if (one.id() == of.key) return one.role();
    return v1::ROLE_UNSPECIFIED;
  }

  SessionsOnAClock s_;
  std::shared_ptr<FakeClient> owner_;
};

TEST_F(Roles, AGuestsInvitationIsOverWithItsOwnAtTheLatest) {
  v1::Invitation first, second, third;
  const auto guest_one = guest(*owner_, v1::ROLE_CONTROLLER, first, 600);
  const auto guest_two = guest(*guest_one, v1::ROLE_CONTROLLER, second, 31536000);
  EXPECT_LE(second.expires_unix_ms(), first.expires_unix_ms());
  const auto guest_three = guest(*guest_two, v1::ROLE_VIEWER, third, 31536000);
  EXPECT_LE(third.expires_unix_ms(), second.expires_unix_ms());
  v1::Invitation shorter;
  guest(*guest_one, v1::ROLE_VIEWER, shorter, 10);
  EXPECT_LT(shorter.expires_unix_ms(), first.expires_unix_ms());
  // Taken back, it takes along what came of it.
  EXPECT_EQ(refusal(*owner_, revoke(first.id())), "");
  for (const auto& gone : {guest_one, guest_two, guest_three}) EXPECT_NE(gone->outbox.closed, 0);
  for (const auto& token : {first.token(), second.token(), third.token(), shorter.token()})
    EXPECT_FALSE(s_.sessions->admit(token));
  EXPECT_EQ(owner_->outbox.closed, 0);
}

TEST_F(Roles, AGuestTakesBackAndSeesNoInvitationButItsOwn) {
  v1::Invitation controls, looks, own;
  const auto controller = guest(*owner_, v1::ROLE_CONTROLLER, controls);
  const auto viewer = guest(*owner_, v1::ROLE_VIEWER, looks);
  const auto of_controller = guest(*controller, v1::ROLE_VIEWER, own);
  EXPECT_EQ(refusal(*controller, revoke(looks.id())), "forbidden");
  EXPECT_EQ(refusal(*controller, revoke(controls.id())), "forbidden");
  EXPECT_EQ(refusal(*controller, revoke("no such one")), "forbidden");
  EXPECT_EQ(viewer->outbox.closed, 0);
  v1::ClientMessage list;
  list.mutable_list_invitations();
  const auto listed = [&](FakeClient& client) {
    s_.say(client, list);
    return client.outbox.newest([](const auto& m) { return m.has_invitations(); }).invitations();
  };
  ASSERT_EQ(listed(*controller).invitations_size(), 1);
  EXPECT_EQ(listed(*controller).invitations(0).id(), own.id());
  EXPECT_EQ(listed(*owner_).invitations_size(), 3);
  EXPECT_EQ(refusal(*controller, revoke(own.id())), "");
  EXPECT_NE(of_controller->outbox.closed, 0);
}

TEST_F(Roles, AGuestTakesNobodysRoleButThatOfItsOwnGuests) {
  v1::Invitation controls, looks, own;
  const auto controller = guest(*owner_, v1::ROLE_CONTROLLER, controls);
  const auto viewer = guest(*owner_, v1::ROLE_VIEWER, looks);
  const auto of_controller = guest(*controller, v1::ROLE_VIEWER, own);
  EXPECT_EQ(refusal(*controller, role_of(owner_->key, v1::ROLE_VIEWER)), "forbidden");
  EXPECT_EQ(role_now(*owner_), v1::ROLE_CONTROLLER);
  EXPECT_EQ(refusal(*controller, role_of(viewer->key, v1::ROLE_CONTROLLER)), "forbidden") << "the owner let it look";
  EXPECT_EQ(role_now(*viewer), v1::ROLE_VIEWER);
  EXPECT_EQ(refusal(*controller, role_of(of_controller->key, v1::ROLE_CONTROLLER)), "");
  EXPECT_EQ(refusal(*of_controller, role_of(controller->key, v1::ROLE_VIEWER)), "forbidden") << "its host";
  EXPECT_EQ(refusal(*controller, role_of(0, v1::ROLE_VIEWER)), "");
  EXPECT_EQ(refusal(*controller, role_of(0, v1::ROLE_CONTROLLER)), "forbidden") << "down is free, up is not";
}

TEST_F(Roles, WhoWasInvitedToLookInvitesNobodyToControlWhenHandedControl) {
  v1::Invitation looks;
  const auto viewer = guest(*owner_, v1::ROLE_VIEWER, looks);
  EXPECT_EQ(refusal(*owner_, role_of(viewer->key, v1::ROLE_CONTROLLER)), "");
  EXPECT_EQ(refusal(*viewer, invite(v1::ROLE_CONTROLLER)), "forbidden");
  EXPECT_EQ(refusal(*viewer, invite(v1::ROLE_VIEWER)), "");
}

TEST_F(Roles, AGuestLeavesRoomForOthersInvitations) {
  v1::Invitation controls;
  const auto controller = guest(*owner_, v1::ROLE_CONTROLLER, controls);
  std::string refused;
  for (std::size_t i = 0; i < Invitations::kMaxInvitations && refused.empty(); ++i)
    refused = refusal(*controller, invite(v1::ROLE_VIEWER));
  EXPECT_EQ(refused, "unavailable");
  EXPECT_EQ(refusal(*owner_, invite(v1::ROLE_VIEWER)), "");
}

// A command that is sent again is done once, whatever guests call themselves and however many come.
TEST_F(Roles, GuestsDoNotMakeTheSessionForgetWhatAControllerDid) {
  auto hello = s_.resuming(*owner_);
  hello.set_client_id("the owner's");
  auto client = s_.connect(hello);
  v1::ClientMessage done = s_.camera(3);
  done.set_command(7);
  s_.say(*client, done);
  v1::Invitation looks;
  guest(*owner_, v1::ROLE_VIEWER, looks);
  for (int i = 0; i < 200; ++i) {
    auto as = s_.looking();
    as.set_client_id(i == 0 ? "the owner's" : "guest " + std::to_string(i));
    const auto one = s_.connect(as, s_.sessions->admit(looks.token()).value_or(Sessions::Admission{}));
    EXPECT_EQ(one->outbox.welcome().last_command(), 0u) << "another's number";
    v1::ClientMessage move = s_.camera(i);
    move.set_command(i == 0 ? 1'000'000 : 1);
    s_.say(*one, move);
    EXPECT_EQ(one->outbox.error().code(), "forbidden");
    s_.leave(*one);
  }
  const auto again = s_.connect(hello);
  EXPECT_EQ(again->outbox.welcome().last_command(), 7u);
}

TEST_F(Roles, AProofOfAnInvitationIsAsGoodAsItsTokenAndEndsWithIt) {
  v1::Invitation looks;
  guest(*owner_, v1::ROLE_VIEWER, looks);
  const std::string proof = proof_of(secret_hash(looks.token()), "an id");
  EXPECT_EQ(proof.find(looks.token()), std::string::npos);
  ASSERT_TRUE(s_.sessions->admit("an id", proof));
  EXPECT_EQ(s_.sessions->admit("an id", proof)->invitation, looks.id());
  EXPECT_FALSE(s_.sessions->admit("another id", proof));
  EXPECT_FALSE(s_.sessions->admit("an id", proof.substr(1)));
  EXPECT_FALSE(s_.sessions->admit("an id", ""));
  EXPECT_EQ(refusal(*owner_, revoke(looks.id())), "");
  EXPECT_FALSE(s_.sessions->admit("an id", proof));
}

// RFC 4231, test case 2.
TEST(Proof, IsHmacSha256) {
  EXPECT_EQ(proof_of("Jefe", "what do ya want for nothing?"), "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
}

/// Who is told to have asked for what.
struct Acts final : SessionsObserver {
  void asked(const Session&, const Viewer& viewer, const std::string& act, std::uint64_t, const std::string& detail) override {
    all.push_back((viewer.invitation.empty() ? "owner " : "guest ") + act + (detail.empty() ? "" : " " + detail));
  }
  std::vector<std::string> all;
};

TEST_F(Roles, WhoDidWhatIsTold) {
  Acts acts;
  s_.sessions->observe(acts);
  v1::Invitation controls;
  const auto controller = guest(*owner_, v1::ROLE_CONTROLLER, controls);
  for (int i = 0; i < 100; ++i) s_.say(*controller, s_.camera(i));
  v1::ClientMessage view, ping;
  view.mutable_set_view()->set_view("+x");
  ping.mutable_ping();
  s_.say(*controller, ping);
  s_.say(*controller, view);
  s_.say(*owner_, revoke(controls.id()));
  const std::vector<std::string> expected{"owner create_invitation controller", "guest join", "guest set_camera",
                                          "guest set_view", "owner revoke_invitation " + controls.id()};
  ASSERT_EQ(acts.all.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(acts.all[i].substr(0, expected[i].size()), expected[i]);
  s_.sessions->end_all();
}

TEST(NothingKept, IsToldToThoseWhoAreThereAndToThoseWhoCome) {
  const testing::TemporaryFolder folder;
  SessionsOptions options;
  options.journal = folder / "sessions";
  SessionsOnAClock s(std::move(options));
  const auto first = s.connect(s.looking());
  s.open();
  std::filesystem::remove_all(folder / "sessions");
  std::ofstream(folder / "sessions") << "in its place";
  const auto told = [](const FakeClient& client) {
    return client.outbox.error().message().find("not being kept") != std::string::npos;
  };
  for (int i = 0; i < 1000 && !told(*first); ++i) {
    s.say(*first, s.camera(i));
    v1::ClientMessage invitation;
    invitation.mutable_create_invitation()->set_role(v1::ROLE_VIEWER);
    if (i < 3) s.say(*first, invitation);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    s.now += std::chrono::milliseconds(10);
    s.sessions->tick(s.now);
  }
  EXPECT_TRUE(told(*first));
  EXPECT_TRUE(told(*s.connect(s.looking())));
}

}  // namespace
}  // namespace isostrata
