// Who is in a session and what each may do: roles, invitations, limits, commands that are sent twice.
#include <gtest/gtest.h>

#include <algorithm>

#include "session/people_messages.h"

namespace isostrata {
namespace {

class People : public ::testing::Test {
 protected:
  People() {
    owner_ = s_.connect(s_.looking());
    s_.open();
  }
  std::shared_ptr<FakeClient> guest(v1::Role role) {
    s_.say(*owner_, invite(role));
    const auto admission = s_.sessions->admit(invitation_of(*owner_).token());
    EXPECT_TRUE(admission);
    return s_.connect(s_.looking(), admission.value_or(Sessions::Admission{}));
  }

  SessionsOnAClock s_;
  std::shared_ptr<FakeClient> owner_;
};

TEST_F(People, SessionsAreApartUnlessATokenJoinsThem) {
  const auto other = s_.connect(s_.looking());
  EXPECT_NE(other->outbox.welcome().session(), owner_->outbox.welcome().session());
  s_.say(*owner_, s_.camera(5));
  EXPECT_NE(other->outbox.state().camera().eye().x(), 5);
  const auto same = s_.connect(s_.resuming(*owner_));
  EXPECT_EQ(same->outbox.welcome().session(), owner_->outbox.welcome().session());
  EXPECT_EQ(same->outbox.welcome().state().camera().eye().x(), 5);
}

TEST_F(People, AViewersCommandsAreForbiddenAndChangeNothing) {
  const auto viewer = guest(v1::ROLE_VIEWER);
  EXPECT_EQ(viewer->outbox.welcome().role(), v1::ROLE_VIEWER);
  const std::string before = owner_->outbox.state().SerializeAsString();
  v1::ClientMessage open, cancel, list;
  open.mutable_open_dataset()->set_id("fin");
  cancel.mutable_cancel()->set_operation(1);
  list.mutable_list_invitations();
  for (const auto& message : {s_.camera(7), open, cancel, list, invite(v1::ROLE_CONTROLLER), role_of(0, v1::ROLE_CONTROLLER),
                              role_of(owner_->key, v1::ROLE_VIEWER)}) {
    const auto errors = viewer->outbox.messages.size();
    s_.say(*viewer, message);
    ASSERT_GT(viewer->outbox.messages.size(), errors) << message.DebugString();
    EXPECT_EQ(viewer->outbox.error().code(), "forbidden") << message.DebugString();
    EXPECT_EQ(viewer->outbox.error().in_reply_to(), viewer->seq);
  }
  EXPECT_EQ(owner_->outbox.state().SerializeAsString(), before);
  EXPECT_EQ(viewer->outbox.closed, 0);
}

TEST_F(People, AVerdictThatWasNotHeardIsToldWithTheNextWelcome) {
  auto hello = s_.resuming(*owner_);
  hello.set_client_id("a-client");
  auto client = s_.connect(hello);
  v1::ClientMessage refused;
  refused.mutable_patch_interval()->set_id(4711);
  refused.set_command(1);
  s_.say(*client, refused);
  auto again = s_.connect(hello);
  EXPECT_EQ(again->outbox.welcome().last_command(), 1u);
  EXPECT_EQ(again->outbox.welcome().last_command_error().code(), "not_found");
  v1::ClientMessage done = s_.camera(3);
  done.set_command(2);
  s_.say(*client, done);
  again = s_.connect(hello);
  EXPECT_EQ(again->outbox.welcome().last_command(), 2u);
  EXPECT_FALSE(again->outbox.welcome().has_last_command_error());
  hello.set_client_id("another-client");
  EXPECT_EQ(s_.connect(hello)->outbox.welcome().last_command(), 0u);
}

TEST_F(People, EveryoneIsToldWhoIsThere) {
  auto hello = s_.resuming(*owner_);
  hello.set_name("Ada");
  hello.set_client("a-test");
  const auto ada = s_.connect(hello);
  const auto seen = owner_->outbox.participants();
  ASSERT_EQ(seen.participants_size(), 2);
  EXPECT_EQ(seen.participants(1).name(), "Ada");
  EXPECT_EQ(seen.participants(1).client(), "a-test");
  EXPECT_FALSE(seen.participants(1).invited());
  EXPECT_EQ(ada->outbox.participants().SerializeAsString(), seen.SerializeAsString());
  EXPECT_TRUE(ada->outbox.messages.front().has_welcome());
  const auto viewer = guest(v1::ROLE_VIEWER);
  EXPECT_TRUE(owner_->outbox.participants().participants(2).invited());
  s_.leave(*ada);
  EXPECT_EQ(owner_->outbox.participants().participants_size(), 2);
}

TEST_F(People, ControlIsHandedOverAndTakenBackByWhoHasTheServersToken) {
  const auto viewer = guest(v1::ROLE_VIEWER);
  s_.say(*owner_, role_of(0, v1::ROLE_VIEWER));
  EXPECT_EQ(owner_->outbox.error().code(), "invalid_argument") << "a session with viewers alone";
  s_.say(*owner_, role_of(viewer->key, v1::ROLE_CONTROLLER));
  s_.say(*owner_, role_of(0, v1::ROLE_VIEWER));
  s_.say(*viewer, s_.camera(3));
  s_.now += std::chrono::milliseconds(10);  // cameras are told on a few hundred times a second at most
  s_.sessions->tick(s_.now);
  EXPECT_EQ(owner_->outbox.state().camera().eye().x(), 3);
  s_.say(*owner_, s_.camera(4));
  EXPECT_EQ(owner_->outbox.error().code(), "forbidden");
  s_.say(*owner_, role_of(0, v1::ROLE_CONTROLLER));
  s_.say(*owner_, role_of(viewer->key, v1::ROLE_VIEWER));
  s_.say(*viewer, s_.camera(5));
  EXPECT_EQ(viewer->outbox.error().code(), "forbidden");
  EXPECT_EQ(owner_->outbox.state().camera().eye().x(), 3);
  s_.say(*owner_, role_of(99999, v1::ROLE_VIEWER));
  EXPECT_EQ(owner_->outbox.error().code(), "not_found");
  s_.say(*owner_, role_of(0, static_cast<v1::Role>(17)));
  EXPECT_EQ(owner_->outbox.error().field(), "role");
}

TEST_F(People, AnInvitationOpensItsOwnSessionOnlyAndGivesNoMoreThanItSays) {
  const auto viewer = guest(v1::ROLE_VIEWER);
  EXPECT_TRUE(viewer->outbox.welcome().resume_token().empty()) << "with it a viewer would come back as controller";
  const auto admission = s_.sessions->admit(invitation_of(*owner_).token());
  auto hello = s_.looking();
  hello.set_role(v1::ROLE_CONTROLLER);
  const auto ambitious = s_.connect(hello, *admission);
  EXPECT_EQ(ambitious->outbox.welcome().role(), v1::ROLE_VIEWER);
  const auto stranger = s_.connect(s_.looking());
  hello.set_resume_token(stranger->outbox.welcome().resume_token());
  EXPECT_EQ(s_.connect(hello, *admission)->outbox.welcome().session(), owner_->outbox.welcome().session());
  EXPECT_FALSE(s_.sessions->admit(invitation_of(*owner_).id()));
  EXPECT_FALSE(s_.sessions->admit(""));
}

TEST_F(People, ARevokedInvitationCutsOffWhoCameByIt) {
  const auto viewer = guest(v1::ROLE_VIEWER);
  const auto made = invitation_of(*owner_);
  v1::ClientMessage list;
  list.mutable_list_invitations();
  s_.say(*owner_, list);
  const auto listed = owner_->outbox.newest([](const auto& m) { return m.has_invitations(); }).invitations();
  ASSERT_EQ(listed.invitations_size(), 1);
  EXPECT_EQ(listed.invitations(0).present(), 1u);
  EXPECT_TRUE(listed.invitations(0).token().empty()) << "the list must not hold what opens the session";
  v1::ClientMessage revoke;
  revoke.mutable_revoke_invitation()->set_id(made.id());
  s_.say(*owner_, revoke);
  EXPECT_EQ(viewer->outbox.closed, 1008);
  EXPECT_EQ(viewer->outbox.error().code(), "forbidden");
  EXPECT_FALSE(s_.sessions->admit(made.token()));
  s_.say(*owner_, revoke);
  EXPECT_EQ(owner_->outbox.error().code(), "not_found");
}

TEST_F(People, AnInvitationEndsWhenItsTimeIsOver) {
  Invitations invitations;
  v1::CreateInvitation wanted;
  wanted.set_role(v1::ROLE_VIEWER);
  wanted.set_seconds(60);
  const auto made = invitations.make(wanted, 1000);
  ASSERT_FALSE(made.error);
  const std::string hash = made.invitation->token_hash;
  EXPECT_TRUE(invitations.find(hash, 60999));
  EXPECT_FALSE(invitations.find(hash, 61000));
  EXPECT_TRUE(invitations.expire(60999).empty());
  EXPECT_EQ(invitations.expire(61000).size(), 1u);
  EXPECT_FALSE(invitations.find(hash, 2000));
}

TEST_F(People, InvitationsOutOfRangeAreRefusedByField) {
  Invitations invitations;
  v1::CreateInvitation wanted;
  EXPECT_EQ(invitations.make(wanted, 0).error->field(), "role");
  wanted.set_role(v1::ROLE_VIEWER);
  for (const double seconds : {-1.0, 0.5, 1e9, std::nan("")}) {
    wanted.set_seconds(seconds);
    EXPECT_EQ(invitations.make(wanted, 0).error->field(), "seconds") << seconds;
  }
  wanted.set_seconds(60);
  wanted.set_name(std::string(1000, 'x'));
  EXPECT_EQ(invitations.make(wanted, 0).error->field(), "name");
  wanted.clear_name();
  for (std::size_t i = 0; i < Invitations::kMaxInvitations; ++i) EXPECT_FALSE(invitations.make(wanted, 0).error);
  EXPECT_EQ(invitations.make(wanted, 0).error->code(), "unavailable");
}

TEST_F(People, ACommandThatIsSentAgainIsDoneOnce) {
  auto hello = s_.resuming(*owner_);
  hello.set_client_id("one-page");
  const auto first = s_.connect(hello);
  auto add = [&](std::uint64_t number) {
    v1::ClientMessage message;
    v1::Interval& interval = *message.mutable_set_intervals()->add_intervals();
    interval.set_lower(1);
    interval.set_upper(2);
    message.set_command(number);
    return message;
  };
  s_.say(*first, add(5));
  const auto revision = owner_->outbox.state().revision();
  const auto id = owner_->outbox.state().intervals(0).id();
  s_.leave(*first);
  const auto again = s_.connect(hello);
  EXPECT_EQ(again->outbox.welcome().last_command(), 5u);
  s_.say(*again, add(5));
  s_.say(*again, add(4));
  EXPECT_EQ(owner_->outbox.state().revision(), revision);
  EXPECT_EQ(owner_->outbox.state().intervals(0).id(), id);
  s_.say(*again, add(6));
  EXPECT_GT(owner_->outbox.state().revision(), revision);
}

TEST_F(People, AnAnswerThatWasLongInComingFollowsItsClientToANewConnection) {
  auto hello = s_.resuming(*owner_);
  hello.set_client_id("one-page");
  const auto first = s_.connect(hello);
  v1::ClientMessage other;
  other.mutable_open_dataset()->set_id("other");
  s_.say(*first, other);
  s_.leave(*first);
  const auto again = s_.connect(hello);
  for (const OpenRequest& request : s_.take<OpenRequest>())
    s_.sessions->on_event(RequestFailed{request.session, request.request, 0, ErrorCode::bad_data, "truncated"}, s_.now);
  EXPECT_EQ(again->outbox.error().message(), "truncated");
  EXPECT_EQ(again->outbox.error().in_reply_to(), 0u) << "a number of another connection";
  EXPECT_TRUE(owner_->outbox.error().code().empty()) << "it is not theirs";
}

TEST_F(People, ADatasetThatAnotherOneOvertookEndsOnNobodysWord) {
  for (const char* id : {"other", "another"}) {
    v1::ClientMessage open;
    open.mutable_open_dataset()->set_id(id);
    s_.say(*owner_, open);
  }
  const auto cancelled = s_.take<CancelRequest>();
  ASSERT_EQ(cancelled.size(), 1u);
  EXPECT_TRUE(cancelled[0].superseded);
  s_.sessions->on_event(OperationDone{cancelled[0].session, 9, true, cancelled[0].request, true}, s_.now);
  const auto done = owner_->outbox.newest([](const auto& m) { return m.has_done(); }).done();
  EXPECT_TRUE(done.cancelled());
  EXPECT_TRUE(done.superseded());
}

TEST_F(People, ProgressSaysWhatIsMissingUntilItIsDone) {
  const auto purpose = [&](SessionKey session, RequestId works_for) {
    s_.sessions->on_event(OperationProgress{session, 9, "working", 0.5, works_for}, s_.now);
    return owner_->outbox.newest([](const auto& m) { return m.has_progress(); }).progress().purpose();
  };
  s_.take<OpenRequest>();
  v1::ClientMessage open, probe;
  open.mutable_open_dataset()->set_id("other");
  probe.mutable_probe_point();
  s_.say(*owner_, probe);
  s_.say(*owner_, open);
  const auto probed = s_.take<ProbeRequest>();
  const auto opened = s_.take<OpenRequest>();
  ASSERT_EQ(probed.size(), 1u);
  ASSERT_EQ(opened.size(), 1u);
  const SessionKey session = opened[0].session;
  EXPECT_EQ(purpose(session, 0), v1::PURPOSE_PICTURE);
  EXPECT_EQ(purpose(session, opened[0].request), v1::PURPOSE_DATASET);
  EXPECT_EQ(purpose(session, probed[0].request), v1::PURPOSE_UNSPECIFIED);
}

TEST(SessionLimits, WhoMayOnlyLookHasStillsOfTheSizeThatTheOwnerAllows) {
  SessionsOptions options;
  options.max_viewer_pixels = 640 * 360;
  SessionsOnAClock s(options);
  const auto owner = s.connect(s.looking());
  s.open();
  s.say(*owner, invite(v1::ROLE_VIEWER));
  const auto guest = s.connect(s.looking(), s.sessions->admit(invitation_of(*owner).token()).value());
  v1::ClientMessage still;
  still.mutable_request_still()->set_width(641);
  still.mutable_request_still()->set_height(360);
  s.say(*guest, still);
  EXPECT_EQ(guest->outbox.error().code(), "too_large");
  EXPECT_NE(guest->outbox.error().message().find("at most 230400 for who may only look"), std::string::npos) << guest->outbox.error().message();
  const auto errors = [](const FakeClient& of) { return std::count_if(of.outbox.messages.begin(), of.outbox.messages.end(), [](const auto& m) { return m.has_error(); }); };
  still.mutable_request_still()->set_width(640);
  s.say(*guest, still);
  EXPECT_EQ(errors(*guest), 1);
  still.mutable_request_still()->set_width(1280);
  s.say(*owner, still);
  EXPECT_EQ(errors(*owner), 0);
}

TEST(SessionLimits, SayWhichAndHowMany) {
  SessionsOptions options;
  options.max_viewers = 2;
  options.max_sessions = 1;
  SessionsOnAClock s(options);
  const auto owner = s.connect(s.looking());
  s.open();
  const auto second = s.connect(s.resuming(*owner));
  const auto third = s.connect(s.resuming(*owner));
  EXPECT_EQ(third->outbox.error().code(), "unavailable");
  EXPECT_NE(third->outbox.error().message().find("2 connections (--max-viewers)"), std::string::npos);
  EXPECT_EQ(third->outbox.closed, 1013);
  const auto other = s.connect(s.looking());
  EXPECT_NE(other->outbox.error().message().find("all 1 sessions"), std::string::npos) << other->outbox.error().message();
  s.leave(*second);
  EXPECT_TRUE(s.connect(s.resuming(*owner))->outbox.error().code().empty());
  auto hello = s.looking();
  hello.set_name(std::string(1000, 'x'));
  EXPECT_EQ(s.connect(hello)->outbox.error().field(), "hello.name");
}

TEST(SessionNotices, AreSaidWithTheirTimeAndTheConnectionGoesOn) {
  SessionsOnAClock s;
  const auto client = s.connect(s.looking());
  s.sessions->announce_end("the job ends", unix_ms_now() + 600000);
  const auto notice = client->outbox.messages.back().shutdown();
  EXPECT_TRUE(notice.notice());
  EXPECT_NEAR(notice.seconds(), 600, 60);
  EXPECT_EQ(client->outbox.closed, 0);
  s.sessions->shut_down("the server was asked to end", std::chrono::seconds(3));
  const auto last = client->outbox.messages.back().shutdown();
  EXPECT_FALSE(last.notice());
  EXPECT_EQ(last.seconds(), 3);
  EXPECT_EQ(client->outbox.closed, 1001);
}

}  // namespace
}  // namespace isostrata
