// Over real sockets: two in one session, invitation links, a restart, the notice before the end.
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <fstream>

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

json::value body_of(const std::string& response) { return json::parse(response.substr(response.find("\r\n\r\n") + 4)); }

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
  const auto cookie = "Cookie: isostrata_guest_" + std::to_string(server_.port()) + "=" + token + "\r\n";
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
