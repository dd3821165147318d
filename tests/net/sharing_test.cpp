// Over real sockets: two in one session, invitation links, a restart, the notice before the end.
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <fstream>

#include "net/answers.h"
#include "net/running_server.h"

namespace isostrata {
namespace {

using client::Client;
using client::ClientError;
namespace json = boost::json;

v1::ClientMessage side(const std::string& view) {
  v1::ClientMessage message;
  message.mutable_set_view()->set_view(view);
  return message;
}

std::string code_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const ClientError& error) {
    return error.code();
  }
  return "";
}

/// Waits for a state or a frame of at least this revision.
bool sees(Client& client, std::uint64_t revision) {
  for (int i = 0; i < 200; ++i) {
    const auto message = client.receive(std::chrono::milliseconds(100));
    if (message && message->has_frame() && message->frame().revision() >= revision) return true;
  }
  return false;
}

client::Options with_token(client::Options options, const std::string& token) {
  options.url = options.url.substr(0, options.url.find('?')) + "?token=" + token;
  return options;
}

class Sharing : public ::testing::Test {
 protected:
  std::string invite(const std::string& session, const std::string& role) {
    const auto answer = server_.ask("POST", "/api/v1/sessions/" + session + "/invitations",
                                    R"({"role":")" + role + R"(","seconds":600,"name":"for a test"})");
    EXPECT_EQ(status_of(answer), 201) << answer;
    invitation_ = std::string(body_of(answer).at("id").as_string());
    return std::string(body_of(answer).at("token").as_string());
  }

  RunningServer server_;
  std::string invitation_;
};

TEST_F(Sharing, AViewerSeesWhatTheControllerDoesAndMayNotDoIt) {
  Client controller(server_.client_options());
  controller.open_dataset("torus-12");
  const auto guest = with_token(server_.client_options(), invite(controller.welcome().session(), "ROLE_VIEWER"));
  Client viewer(guest);
  EXPECT_EQ(viewer.welcome().session(), controller.welcome().session());
  EXPECT_EQ(viewer.welcome().role(), v1::ROLE_VIEWER);
  EXPECT_EQ(viewer.state().dataset(), "torus-12");
  controller.command(side("+x"));
  EXPECT_TRUE(sees(viewer, controller.state().revision()));
  EXPECT_EQ(viewer.state().camera().eye().x(), controller.state().camera().eye().x());
  EXPECT_EQ(code_of([&] { viewer.command(side("+y")); }), "forbidden");
  EXPECT_EQ(viewer.lossless_frame().revision(), controller.state().revision());
  v1::ClientMessage place;
  place.mutable_probe_point()->set_x(0.5);
  const auto seq = viewer.send(std::move(place));
  bool told = false;
  for (int i = 0; i < 200 && !told; ++i) {
    const auto message = viewer.receive(std::chrono::seconds(1));
    told = message && message->has_probe_result() && message->probe_result().in_reply_to() == seq;
  }
  EXPECT_TRUE(told);
}

// A screen of 67 million pixels, and stills of as many, as often as they go over the line.
TEST_F(Sharing, WhoMayOnlyLookGetsSmallerPicturesAndFewStills) {
  Client owner(server_.client_options());
  owner.open_dataset("torus-12");
  auto options = with_token(server_.client_options(), invite(owner.welcome().session(), "ROLE_VIEWER"));
  options.width = 16384;
  options.height = 4096;
  Client viewer(options);
  constexpr double kMost = 4096 * 2160;
  const auto pixels = [](const v1::Frame& frame) { return static_cast<double>(frame.width()) * frame.height(); };
  std::optional<v1::Frame> seen;
  for (int i = 0; i < 400 && !seen; ++i)
    if (auto message = viewer.receive(std::chrono::milliseconds(100)); message && message->has_frame()) seen = message->frame();
  ASSERT_TRUE(seen);
  EXPECT_LE(pixels(*seen), kMost);
  EXPECT_NEAR(static_cast<double>(seen->width()) / seen->height(), 4, 0.1) << "the same shape";

  const int drawn = server_.control->drawn;
  int too_large = 0, too_often = 0;
  for (int i = 0; i < 40; ++i) {
    v1::ClientMessage still;
    still.mutable_request_still()->set_width(i % 2 == 0 ? 16384 : 400u + static_cast<unsigned>(i));
    still.mutable_request_still()->set_height(i % 2 == 0 ? 4096 : 300);
    viewer.send(still);
  }
  v1::ClientMessage ping;
  ping.mutable_ping()->set_client_time_ms(7);
  viewer.send(ping);
  for (bool done = false; !done;) {
    const auto message = viewer.receive(std::chrono::milliseconds(8000));
    ASSERT_TRUE(message);
    if (message->has_error()) (message->error().code() == "too_large" ? too_large : too_often)++;
    if (message->has_frame()) {
      EXPECT_LE(pixels(message->frame()), kMost);
    }
    done = message->has_pong();
  }
  EXPECT_EQ(too_large, 20);
  EXPECT_GE(too_often, 14) << "a few at once, then one every two seconds";
  EXPECT_LE(server_.control->drawn - drawn, 12);
  // The owner's own are as large as ever.
  v1::ClientMessage still;
  still.mutable_request_still()->set_width(4200);
  still.mutable_request_still()->set_height(2200);
  owner.send(still);
  bool whole = false;
  for (int i = 0; i < 100 && !whole; ++i)
    if (auto message = owner.receive(std::chrono::milliseconds(200)); message && message->has_frame())
      whole = message->frame().width() == 4200;
  EXPECT_TRUE(whole);
}

TEST_F(Sharing, AnInvitedControllerChangesWhatIsShown) {
  Client owner(server_.client_options());
  owner.open_dataset("torus-12");
  Client friend_(with_token(server_.client_options(), invite(owner.welcome().session(), "ROLE_CONTROLLER")));
  friend_.command(side("+z"));
  EXPECT_TRUE(sees(owner, friend_.state().revision()));
}

TEST_F(Sharing, AnInvitationOpensThePageAndItsSessionAndNothingElse) {
  Client owner(server_.client_options());
  const std::string session = owner.welcome().session();
  const std::string token = invite(session, "ROLE_VIEWER");
  const auto asks = [&](const std::string& target, const std::string& headers = "") {
    return server_.raw("GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + headers + "\r\n");
  };
  const auto page = asks("/?token=" + token);
  EXPECT_NE(status_of(page), 401) << page;
  EXPECT_TRUE(has(page, "isostrata_guest_")) << page;
  EXPECT_FALSE(has(page, RunningServer::kToken));
  EXPECT_EQ(status_of(asks("/api/v1/sessions?token=" + token)), 403);
  EXPECT_EQ(status_of(asks("/api/v1/sessions/" + session, "Authorization: Bearer " + token + "\r\n")), 403);
  EXPECT_EQ(status_of(asks("/api/v1/sessions?token=" + token + "x")), 401);
  EXPECT_FALSE(has(page, token)) << "the cookie is not the token";
  const auto at = page.find("Set-Cookie: ") + 12;
  const auto cookie = "Cookie: " + page.substr(at, page.find(';', at) - at) + "\r\n";
  EXPECT_NE(status_of(asks("/", cookie)), 401);
  EXPECT_EQ(status_of(asks("/api/v1/datasets", cookie)), 403);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket("/ws", cookie)), 101);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket("/ws?token=" + token + "x")), 401);
}

TEST_F(Sharing, InvitationsAreListedWithoutTokensAndTakenBackAtOnce) {
  Client owner(server_.client_options());
  const std::string below = "/api/v1/sessions/" + owner.welcome().session() + "/invitations";
  const std::string token = invite(owner.welcome().session(), "ROLE_VIEWER");
  Client viewer(with_token(server_.client_options(), token));
  const auto list = server_.ask("GET", below);
  EXPECT_FALSE(has(list, token));
  EXPECT_EQ(body_of(list).at("invitations").as_array().at(0).at("present").to_number<int>(), 1);
  const auto people = body_of(server_.ask("GET", "/api/v1/sessions/" + owner.welcome().session() + "/participants"));
  EXPECT_EQ(people.at("participants").as_array().size(), 2u);
  EXPECT_EQ(status_of(server_.ask("DELETE", below + "/" + invitation_)), 204);
  EXPECT_EQ(status_of(server_.ask("DELETE", below + "/" + invitation_)), 404);
  EXPECT_EQ(code_of([&] {
              for (int i = 0; i < 200; ++i) viewer.receive(std::chrono::milliseconds(100));
            }),
            "closed");
  EXPECT_EQ(code_of([&] { Client again(with_token(server_.client_options(), token)); }), "unauthorized");
  EXPECT_EQ(status_of(server_.ask("POST", below, R"({"role":"ROLE_VIEWER","seconds":-1})")), 400);
  EXPECT_EQ(status_of(server_.ask("POST", below, R"({"role":7})")), 400);
}

TEST(Restarted, ASessionGoesOnWithTheSameStateOverSocketsAndRest) {
  testing::TemporaryFolder folder;
  ServerOptions options;
  options.state_dir = folder.path();
  std::string token, state, session;
  {
    RunningServer server(options);
    Client client(server.client_options());
    client.open_dataset("tets-6");
    client.command(side("+y"));
    token = client.welcome().resume_token();
    session = client.welcome().session();
    state = client.state().SerializeAsString();
  }
  RunningServer server(options);
  // First by its id, as a script does: it wakes for that.
  const auto image = server.ask("GET", "/api/v1/sessions/" + session + "/image?width=32&height=24");
  EXPECT_EQ(status_of(image), 200) << image.substr(0, 400);
  auto resuming = server.client_options();
  resuming.resume_token = token;
  Client client(resuming);
  EXPECT_EQ(client.welcome().session(), session);
  EXPECT_EQ(client.state().SerializeAsString(), state);
  EXPECT_EQ(client.lossless_frame().revision(), client.state().revision());
  EXPECT_EQ(client.state().SerializeAsString(), state) << "to look changes nothing";
  client.command(side("-y"));
  EXPECT_GT(client.lossless_frame().revision(), 0u);
}

TEST(Restarted, AStateDirectoryThatCannotBeUsedDoesNotKeepTheServerFromServing) {
  testing::TemporaryFolder folder;
  std::ofstream(folder / "sessions") << "a file";
  ServerOptions options;
  options.state_dir = folder.path();
  std::string warned;
  options.warn = [&](const std::string& what) { warned = what; };
  RunningServer server(options);
  EXPECT_TRUE(has(warned, "will not survive")) << warned;
  Client client(server.client_options());
  client.open_dataset("tets-6");
  EXPECT_EQ(client.lossless_frame().width(), 64u);
}

TEST(EndOfTheJob, IsToldToWhoIsThereAndToWhoComes) {
  ServerOptions options;
  options.ends = std::chrono::system_clock::now() + std::chrono::seconds(601);
  RunningServer server(options);
  Client client(server.client_options());
  EXPECT_GT(client.welcome().ends_unix_ms(), 0);
  v1::Shutdown notice;
  for (int i = 0; i < 200 && notice.reason().empty(); ++i)
    if (const auto message = client.receive(std::chrono::milliseconds(100)); message && message->has_shutdown())
      notice = message->shutdown();
  EXPECT_TRUE(notice.notice());
  EXPECT_GT(notice.seconds(), 540);
  client.open_dataset("tets-6");
  EXPECT_EQ(client.lossless_frame().width(), 64u);
}

}  // namespace
}  // namespace isostrata
