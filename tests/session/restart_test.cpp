// A session in a server's next life: the same state to the last byte, the same tokens, and no secret on the disk.
#include <gtest/gtest.h>

#include <iterator>

#include "session/fake_engine.h"
#include "session/people_messages.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

class Restart : public ::testing::Test {
 protected:
  Restart() { begin(); }
  void begin() {
    SessionsOptions options;
    options.journal = folder_ / "sessions";
    options.max_sessions = 4;
    s_ = std::make_unique<SessionsOnAClock>(options);
  }
  void restart() {
    s_.reset();
    begin();
  }
  double eye_x() { return s_->sessions->list().front()->wire_state().camera().eye().x(); }
  std::string on_disk() {
    std::string all;
    for (const auto& file : fs::directory_iterator(folder_ / "sessions")) {
      std::ifstream in(file.path(), std::ios::binary);
      all.append(std::istreambuf_iterator<char>(in), {});
    }
    return all;
  }

  testing::TemporaryFolder folder_;
  std::unique_ptr<SessionsOnAClock> s_;
};

// A bit of everything that a scene can hold.
void furnish(SessionsOnAClock& s, FakeClient& client) {
  s.say(client, s.camera(3.0000000000000004));
  v1::ClientMessage intervals;
  for (int i = 0; i < 3; ++i) {
    v1::Interval& interval = *intervals.mutable_set_intervals()->add_intervals();
    interval.set_lower(0.1 * i);
    interval.set_upper(0.1 * i + 1.0 / 3);
    interval.mutable_color()->set_r(0.1f);
    interval.set_opacity(1.0 / 7);
    interval.set_priority(7 - i);
    interval.set_visible(i != 1);
    interval.set_name("layer " + std::to_string(i));
    interval.set_opacity_upper(0.25);
    interval.mutable_surface()->set_lower(true);
    interval.mutable_surface()->set_texture("stripes");
  }
  s.say(client, intervals);
  v1::ClientMessage remove;
  remove.mutable_remove_interval()->set_id(client.outbox.state().intervals(1).id());
  s.say(client, remove);
  v1::ClientMessage look;
  look.mutable_set_appearance()->mutable_background()->set_g(0.3f);
  look.mutable_set_appearance()->set_unit_distance(0.7);
  look.mutable_set_appearance()->set_mode(v1::RENDER_MODE_PRIORITIZED);
  s.say(client, look);
  v1::ClientMessage planes;
  v1::ClipPlane& plane = *planes.mutable_set_clip_planes()->add_clip_planes();
  plane.mutable_normal()->set_x(0.6);
  plane.mutable_normal()->set_y(0.8);
  plane.set_offset(0.1);
  s.say(client, planes);
  v1::ClientMessage time;
  time.mutable_set_time()->set_time(1.25);
  time.mutable_set_time()->set_mode(v1::TIME_MODE_INTERPOLATE);
  s.say(client, time);
  v1::ClientMessage annotations;
  annotations.mutable_set_annotations()->mutable_annotations()->set_legend(true);
  s.say(client, annotations);
  v1::ClientMessage terms;
  v1::RangeTerm& term = *terms.mutable_set_combination()->add_terms();
  term.set_op(v1::RANGE_OPERATOR_SUBTRACT);
  term.set_array("Density");
  term.set_lower(1);
  term.set_upper(1.5);
  s.say(client, terms);
  v1::ClientMessage smear;
  smear.mutable_set_smear()->mutable_smear()->add_steps(1);
  s.say(client, smear);
  EXPECT_TRUE(client.outbox.error().code().empty()) << client.outbox.error().message();
}

TEST_F(Restart, TheStateIsTheSameToTheLastByteAndAKeyFrameComes) {
  const auto before = s_->connect(s_->looking());
  s_->open();
  furnish(*s_, *before);
  const auto hello = s_->resuming(*before);
  restart();
  const auto after = s_->connect(hello);
  const v1::Welcome welcome = after->outbox.welcome();
  EXPECT_EQ(welcome.session(), before->outbox.welcome().session());
  EXPECT_EQ(welcome.state().SerializeAsString(), before->outbox.state().SerializeAsString()) << welcome.state().DebugString();
  EXPECT_EQ(welcome.resume_token(), before->outbox.welcome().resume_token());
  EXPECT_TRUE(s_->take<FrameRequest>().empty()) << "there is nothing to draw before the dataset is open";
  s_->open();
  const auto* session = s_->sessions->list().front();
  EXPECT_EQ(session->wire_state().SerializeAsString(), before->outbox.state().SerializeAsString());
  const auto updates = s_->take<SceneUpdate>();
  ASSERT_EQ(updates.size(), 1u);
  const auto frames = s_->take<FrameRequest>();
  ASSERT_EQ(frames.size(), 1u);
  s_->start(frames[0]);
  s_->finish(frames[0], welcome.state().revision());
  ASSERT_EQ(after->outbox.frames.size(), 1u);
  EXPECT_EQ(after->outbox.frames[0].revision(), welcome.state().revision());
}

TEST_F(Restart, IdsAreNeverUsedAgainAndRevisionsGoOn) {
  const auto before = s_->connect(s_->looking());
  s_->open();
  furnish(*s_, *before);
  std::uint32_t newest = 0;
  const v1::State old = before->outbox.state();
  for (const auto& interval : old.intervals()) newest = std::max(newest, interval.id());
  const auto hello = s_->resuming(*before);
  restart();
  const auto after = s_->connect(hello);
  v1::ClientMessage add;
  add.mutable_set_intervals()->add_intervals()->set_upper(1);
  s_->say(*after, add);  // while the dataset is still being opened
  EXPECT_TRUE(after->outbox.error().code().empty());
  s_->open();
  EXPECT_EQ(after->outbox.state().revision(), before->outbox.state().revision() + 1);
  EXPECT_GT(after->outbox.state().intervals(0).id(), newest);
}

// What a client does not know to have arrived it sends again; what it is told was judged it forgets. So the journal may claim no
// more than the state that it keeps contains.
TEST_F(Restart, TheJournalClaimsNoCommandThatStillWaitedForADataset) {
  auto hello = s_->looking();
  hello.set_client_id("one-page");
  const auto before = s_->connect(hello);
  s_->open();
  const auto numbered = [](v1::ClientMessage message, std::uint64_t number) {
    message.set_command(number);
    return message;
  };
  v1::ClientMessage other;
  other.mutable_open_dataset()->set_id("other");
  s_->say(*before, numbered(s_->camera(5), 1));
  s_->say(*before, numbered(other, 2));
  s_->say(*before, numbered(s_->camera(7), 3));  // waits
  v1::ClientMessage invite;
  invite.mutable_create_invitation()->set_role(v1::ROLE_VIEWER);
  s_->say(*before, invite);  // kept at once
  hello.set_resume_token(before->outbox.welcome().resume_token());
  restart();
  const auto after = s_->connect(hello);
  EXPECT_EQ(after->outbox.welcome().last_command(), 1u);
  EXPECT_EQ(after->outbox.welcome().state().camera().eye().x(), 5);
  s_->open();
  s_->say(*after, numbered(s_->camera(6), 1));
  EXPECT_EQ(eye_x(), 5) << "done before";
  s_->say(*after, numbered(other, 2));
  s_->say(*after, numbered(s_->camera(7), 3));
  s_->open();
  EXPECT_EQ(eye_x(), 7);
  hello.set_resume_token(after->outbox.welcome().resume_token());
  restart();
  EXPECT_EQ(s_->connect(hello)->outbox.welcome().last_command(), 3u);
}

TEST_F(Restart, CommandsThatCameWhileTheDatasetWasOpenedAgainAreClaimedOneByOne) {
  auto hello = s_->looking();
  hello.set_client_id("one-page");
  const auto before = s_->connect(hello);
  s_->open();
  hello.set_resume_token(before->outbox.welcome().resume_token());
  restart();
  const auto asleep = s_->connect(hello);
  for (std::uint64_t number = 1; number <= 3; ++number) {
    v1::ClientMessage camera = s_->camera(static_cast<double>(number));
    camera.set_command(number);
    s_->say(*asleep, camera);
  }
  EXPECT_EQ(s_->sessions->list().front()->entry().clients(0).last_command(), 0u);
  s_->open();
  EXPECT_EQ(s_->sessions->list().front()->entry().clients(0).last_command(), 3u);
  EXPECT_EQ(eye_x(), 3);
}

TEST_F(Restart, HowLargeThePicturesOfThoseWhoOnlyLookAreIsKept) {
  const auto before = s_->connect(s_->looking());
  s_->open();
  s_->say(*before, viewer_size(640, 360));
  const auto hello = s_->resuming(*before);
  restart();
  const auto after = s_->connect(hello);
  EXPECT_EQ(after->outbox.participants().viewer_width(), 640u);
  EXPECT_EQ(after->outbox.participants().viewer_height(), 360u);
}

TEST_F(Restart, NoSecretIsOnTheDisk) {
  const auto client = s_->connect(s_->looking());
  s_->open();
  v1::ClientMessage invite;
  invite.mutable_create_invitation()->set_role(v1::ROLE_VIEWER);
  s_->say(*client, invite);
  const std::string invitation = client->outbox.messages.back().invitation().token();
  ASSERT_FALSE(invitation.empty());
  ASSERT_TRUE(s_->sessions->flush_journal(std::chrono::seconds(20)));
  const std::string bytes = on_disk();
  EXPECT_NE(bytes.find("isostrata-journal"), std::string::npos);
  EXPECT_EQ(bytes.find(client->outbox.welcome().resume_token()), std::string::npos);
  EXPECT_EQ(bytes.find(invitation), std::string::npos);
  restart();
  EXPECT_TRUE(s_->sessions->admit(invitation)) << "links live on";
}

TEST_F(Restart, CommandsThatWereDoneInTheLastLifeAreNotDoneAgain) {
  auto hello = s_->looking();
  hello.set_client_id("one-page");
  const auto before = s_->connect(hello);
  s_->open();
  auto move = s_->camera(4);
  move.set_command(9);
  s_->say(*before, move);
  hello.set_resume_token(before->outbox.welcome().resume_token());
  restart();
  const auto after = s_->connect(hello);
  EXPECT_EQ(after->outbox.welcome().last_command(), 9u);
  s_->open();
  s_->say(*after, move);
  EXPECT_EQ(s_->sessions->list().front()->wire_state().SerializeAsString(), before->outbox.state().SerializeAsString());
}

TEST_F(Restart, ADatasetThatIsAnotherNowIsShownAnewAndThatIsSaid) {
  const auto before = s_->connect(s_->looking());
  s_->open();
  furnish(*s_, *before);
  const auto hello = s_->resuming(*before);
  restart();
  const auto after = s_->connect(hello);
  s_->open("Pressure");
  EXPECT_EQ(after->outbox.error().code(), "bad_data") << after->outbox.error().message();
  EXPECT_EQ(after->outbox.state().array(), "Pressure");
  EXPECT_GT(after->outbox.state().revision(), before->outbox.state().revision());
}

TEST_F(Restart, ADatasetThatIsGoneLeavesTheSessionAsItWasForTheNextTime) {
  const auto before = s_->connect(s_->looking());
  s_->open();
  const auto hello = s_->resuming(*before);
  restart();
  {
    const auto after = s_->connect(hello);
    for (const auto& request : s_->take<OpenRequest>())
      s_->sessions->on_event(RequestFailed{request.session, request.request, 0, ErrorCode::not_found, "it is not there"},
                             s_->now);
    EXPECT_EQ(after->outbox.error().code(), "not_found");
    s_->say(*after, s_->camera(1));
    EXPECT_EQ(after->outbox.error().code(), "unavailable");
    EXPECT_EQ(after->outbox.closed, 0);
    s_->leave(*after);
  }
  restart();
  EXPECT_EQ(s_->connect(hello)->outbox.welcome().state().SerializeAsString(), before->outbox.state().SerializeAsString());
}

TEST_F(Restart, ASessionThatEndedDoesNotComeBackNorOneThatNobodyResumesInItsTime) {
  const auto first = s_->connect(s_->looking());
  const auto second = s_->connect(s_->looking());
  ASSERT_TRUE(s_->sessions->end(first->outbox.welcome().session()));
  restart();
  ASSERT_EQ(s_->sessions->list().size(), 1u);
  EXPECT_EQ(s_->sessions->list().front()->id(), second->outbox.welcome().session());
  s_->sessions->tick(std::chrono::steady_clock::now() + std::chrono::hours(1));
  EXPECT_TRUE(s_->sessions->list().empty());
  restart();
  EXPECT_TRUE(s_->sessions->list().empty());
}

TEST_F(Restart, MoreThanThereIsRoomForAreTheNewest) {
  std::vector<std::shared_ptr<FakeClient>> clients;
  for (int i = 0; i < 4; ++i) clients.push_back(s_->connect(s_->looking()));
  s_->leave(*clients[0]);
  clients.push_back(s_->connect(s_->looking()));  // makes room for itself
  restart();
  EXPECT_EQ(s_->sessions->list().size(), 4u);
  EXPECT_FALSE(s_->sessions->find(clients[0]->outbox.welcome().session()));
}

// A server that begins with as many sessions as it may hold must not shut everyone else out.
TEST_F(Restart, WhoSaidGoodbyeMakesRoomInTheNextLifeAndWhoVanishedDoesNot) {
  std::vector<std::shared_ptr<FakeClient>> people;
  for (int i = 0; i < 4; ++i) {
    people.push_back(s_->connect(s_->looking()));
    s_->open();
    furnish(*s_, *people.back());
  }
  for (int i = 0; i < 4; ++i) s_->leave(*people[i], i >= 2);
  restart();
  ASSERT_EQ(s_->sessions->list().size(), 4u);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(s_->connect(s_->looking())->outbox.error().code(), "");
  EXPECT_EQ(s_->connect(s_->looking())->outbox.error().code(), "unavailable");
  for (int i = 0; i < 4; ++i) EXPECT_EQ(s_->sessions->find(people[i]->outbox.welcome().session()) != nullptr, i < 2) << i;
}

TEST_F(Restart, AGoodbyeIsNotForWhoVanishedBefore) {
  const auto person = s_->connect(s_->looking());
  s_->open();
  furnish(*s_, *person);
  const auto other = s_->connect(s_->resuming(*person));
  s_->leave(*person);
  s_->leave(*other, true);
  EXPECT_EQ(s_->sessions->list().front()->holds(), SessionUse::Holds::work);
  const auto back = s_->connect(s_->resuming(*person));
  s_->leave(*back, true);
  EXPECT_EQ(s_->sessions->list().front()->holds(), SessionUse::Holds::look);
}

TEST_F(Restart, WhoCameBackAfterAGoodbyeIsThereInTheNextLife) {
  const auto person = s_->connect(s_->looking());
  s_->open();
  furnish(*s_, *person);
  s_->leave(*person, true);
  const auto back = s_->connect(s_->resuming(*person));
  restart();
  EXPECT_EQ(s_->sessions->list().front()->holds(), SessionUse::Holds::work);
}

}  // namespace
}  // namespace isostrata
