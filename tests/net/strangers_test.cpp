// What somebody without the token, or without manners, may cost the owner: over real sockets, each beside an owner who is served.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <limits>
#include <memory>
#include <mutex>
#include <tuple>

#include "base/utf8.h"
#include "net/answers.h"
#include "net/running_server.h"
#include "support/places.h"

namespace isostrata {
namespace {

namespace json = boost::json;
using client::Client;

/// The places of a server with this many sessions, as many as there are.
constexpr std::size_t kPlaces = 256 + 2 * 32;

std::vector<std::unique_ptr<RawSocket>> crowd(const RunningServer& server, std::size_t size, const std::string& says) {
  std::vector<std::unique_ptr<RawSocket>> all;
  for (std::size_t i = 0; i < size; ++i) {
    all.push_back(std::make_unique<RawSocket>(server.port()));
    all.back()->send(says);
  }
  return all;
}

TEST(Strangers, IdleConnectionsWithoutATokenKeepNobodyOut) {
  RunningServer server;
  Client owner(server.client_options());
  owner.open_dataset("torus-12");
  for (const std::string says : {"", "GET / HTTP/1.1\r\nHo", "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"}) {
    const auto strangers = crowd(server, 2 * kPlaces, says);
    EXPECT_EQ(status_of(server.ask("GET", "/api/v1/sessions")), 200) << "beside a crowd that says '" << says << "'";
    Client another(server.client_options());
    EXPECT_FALSE(another.welcome().session().empty());
  }
  EXPECT_NO_THROW(owner.lossless_frame()) << "who is in a session stays in it";
}

TEST(Strangers, OfTheOwnersOwnIdleConnectionsTheOldestMakesRoom) {
  RunningServer server;
  const std::string asks =
      "GET /api/v1/datasets HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " + std::string(RunningServer::kToken) + "\r\n\r\n";
  const auto idle = crowd(server, kPlaces + 8, asks);
  EXPECT_EQ(status_of(idle.back()->read_response()), 200);
  bool closed = false;
  idle.front()->read_all(&closed, 2000);
  EXPECT_TRUE(closed);
  EXPECT_EQ(status_of(server.ask("GET", "/api/v1/datasets")), 200);
}

TEST(Strangers, AConnectionThatSaysNothingIsClosedInSeconds) {
  RunningServer server;
  RawSocket probe(server.port());
  probe.send("GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(status_of(probe.read_response()), 200);
  bool closed = false;
  probe.read_all(&closed, 20000);  // one with the token may wait for a minute
  EXPECT_TRUE(closed);
}

// The body never comes, so an answer proves that nobody waited for it.
TEST(Strangers, ARequestWithoutTheTokenIsRefusedByItsHeadAlone) {
  RunningServer server;
  Client owner(server.client_options());
  const auto invitation = body_of(server.ask("POST", "/api/v1/sessions/" + owner.welcome().session() + "/invitations",
                                             R"({"role":"ROLE_VIEWER","seconds":600})"));
  const std::string guest = "Authorization: Bearer " + std::string(invitation.at("token").as_string()) + "\r\n";
  for (const auto& [headers, status] : {std::pair{std::string(), 401}, std::pair{std::string("Authorization: Bearer x\r\n"), 401},
                                        std::pair{guest, 403}}) {
    RawSocket socket(server.port());
    socket.send("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n" + headers + "\r\n{");
    bool closed = false;
    const std::string answer = socket.read_all(&closed, 8000);
    EXPECT_EQ(status_of(answer), status) << answer;
    EXPECT_TRUE(closed) << "what follows the head would be taken for another request";
  }
  for (const std::string path : {"/healthz", "/readyz"}) {
    const auto answer = server.raw("GET " + path + " HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000\r\n\r\n");
    EXPECT_EQ(status_of(answer), 200) << answer;
  }
  // Who sends all of it first reads the answer, too.
  RawSocket sender(server.port());
  sender.send("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 40000\r\n\r\n" + std::string(40000, ' '));
  EXPECT_EQ(status_of(sender.read_all()), 401);
  EXPECT_EQ(status_of(server.ask("POST", "/api/v1/sessions", "{}")), 201);
}

TEST(Strangers, APageOfAnotherPortIsAnotherOrigin) {
  RunningServer server;
  const std::string port = std::to_string(server.port());
  const std::string bearer = "Authorization: Bearer " + std::string(RunningServer::kToken) + "\r\n";
  const auto ask = [&](const std::string& host, const std::string& origin) {
    return status_of(server.raw("GET /api/v1/sessions HTTP/1.1\r\nHost: " + host + "\r\nOrigin: " + origin + "\r\n" + bearer +
                                "Connection: close\r\n\r\n"));
  };
  const auto socket = [&](const std::string& host, const std::string& origin) {
    return status_of(RawSocket(server.port()).open_websocket("/ws", "Origin: " + origin + "\r\n" + bearer, host));
  };
  for (const std::string& host : {"127.0.0.1:" + port, "localhost:" + port}) {
    for (const std::string origin : {"http://127.0.0.1", "https://127.0.0.1", "http://localhost", "http://127.0.0.1:1"}) {
      EXPECT_EQ(ask(host, origin), 403) << host << " " << origin;
      EXPECT_EQ(socket(host, origin), 403) << host << " " << origin;
    }
    EXPECT_EQ(ask(host, "http://" + host), 200);
    EXPECT_EQ(socket(host, "http://" + host), 101);
  }
}

TEST(Strangers, NamesThatAreNoUtf8AreShownWithEscapesAndOpenedById) {
  testing::TemporaryFolder data;
  const std::string name = "caf\xe9\xff.vtk";
  data.write(name,
             "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\nORIGIN 0 0 0\nSPACING 1 1 1\n"
             "POINT_DATA 27\nSCALARS f float\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26\n");
  data.write("broken\xfe.vtk", "no data at all");
  std::string log;
  std::mutex mutex;
  ServerOptions options;
  options.engine.catalogue = Catalogue::from_sources({data.path().string()});
  options.engine.store.importer = isostrata::places::binaries() + "/isostrata-import";
  options.log = [&](const LogLine& line) {
    const std::lock_guard guard(mutex);
    log += line.message + "\n";
    for (const auto& [key, value] : line.fields) log += value + "\n";
  };
  {
    RunningServer server(std::move(options));
    const auto answer = server.ask("GET", "/api/v1/datasets");
    ASSERT_EQ(valid_utf8(answer), answer);
    const auto datasets = body_of(answer).at("datasets").as_array();
    ASSERT_EQ(datasets.size(), 2u);
    EXPECT_EQ(datasets[1].at("name").as_string(), "caf\\xe9\\xff.vtk");
    const std::string id(datasets[1].at("id").as_string()), broken(datasets[0].at("id").as_string());
    Client client(server.client_options());  // its parser refuses text that is not UTF-8
    EXPECT_EQ(client.welcome().datasets(1).name(), "caf\\xe9\\xff.vtk");
    client.open_dataset(id);
    EXPECT_EQ(client.state().dataset(), id);
    EXPECT_NO_THROW(client.lossless_frame());
    for (const std::string& target :
         {"/api/v1/datasets/" + id, "/api/v1/datasets/" + broken, std::string("/api/v1/%ff"), std::string("/%ff"),
          std::string("/api/v1/datasets?%fe=%ff"), std::string("/api/v1/sessions/%ff")}) {
      const auto response = server.ask("GET", target);
      EXPECT_EQ(valid_utf8(response), response) << target;
    }
    EXPECT_EQ(status_of(server.ask("GET", "/api/v1/datasets/" + id)), 200);
  }
  EXPECT_EQ(valid_utf8(log), log);
  EXPECT_TRUE(has(log, "/\\xff")) << log;
}

TEST(Strangers, EmptySessionsTakeNobodysPlace) {
  ServerOptions options;
  options.max_sessions = 8;
  RunningServer server(std::move(options));
  std::string session;
  {
    Client person(server.client_options());
    person.open_dataset("torus-12");
    session = person.welcome().session();
    const auto first = body_of(server.ask("GET", "/api/v1/sessions/" + session + "/intervals")).at("intervals").at(0).at("id");
    EXPECT_EQ(status_of(server.ask("PATCH", "/api/v1/sessions/" + session + "/intervals/" + json::serialize(first),
                                   R"({"lower": 0.1, "upper": 0.2})")),
              200);
    RawSocket lost(server.port());
    const std::string token = person.welcome().resume_token();
    ASSERT_EQ(status_of(lost.open_websocket("/ws?token=" + std::string(RunningServer::kToken))), 101);
    v1::ClientMessage hello;
    hello.set_seq(1);
    hello.mutable_hello()->set_protocol_major(1);
    hello.mutable_hello()->set_resume_token(token);
    lost.send_frame(hello.SerializeAsString());
    ASSERT_TRUE(lost.read_frame());
    person.close();
    lost.reset();  // the last that is there vanishes without a word
  }
  int made = 0, refused = 0;
  std::string refusal;
  for (int i = 0; i < 40; ++i) {
    const auto answer = server.ask("POST", "/api/v1/sessions");
    made += status_of(answer) == 201;
    refused += status_of(answer) == 503;
    if (status_of(answer) == 503) refusal = answer;
  }
  EXPECT_EQ(made + refused, 40);
  EXPECT_GT(made, 0) << "empty ones make room for one another";
  EXPECT_EQ(status_of(server.ask("GET", "/api/v1/sessions/" + session)), 200) << "the person can come back";
  // Sessions that show something are nobody's either, as long as nobody has worked on them.
  for (int i = 0; i < 40; ++i) server.ask("POST", "/api/v1/sessions", R"({"dataset": "tets-6"})");
  EXPECT_EQ(status_of(server.ask("GET", "/api/v1/sessions/" + session)), 200);
  for (int i = 0; i < 8; ++i) server.ask("POST", "/api/v1/sessions", R"({"dataset": "tets-6"})");
  const auto full = server.ask("POST", "/api/v1/sessions");
  EXPECT_EQ(status_of(full), 503) << full;
  EXPECT_TRUE(has(full, "--max-sessions")) << full;
}

// Of a WebSocket: what is done is told by a State, also where it changes nothing, and by which message it was asked for.
TEST(Acknowledgement, EveryCommandIsAnsweredAlsoOneThatChangesNothing) {
  RunningServer server;
  Client client(server.client_options());
  client.open_dataset("torus-12");
  const v1::Interval interval = client.state().intervals(0);
  v1::ClientMessage patch, view, mode, cancel;
  patch.mutable_patch_interval()->set_id(interval.id());
  patch.mutable_patch_interval()->set_lower(interval.lower());
  view.mutable_set_view()->set_view("+x");
  mode.mutable_set_appearance()->set_mode(v1::RENDER_MODE_SORTED);
  cancel.mutable_cancel()->set_operation(12345);
  v1::ClientMessage camera;
  camera.mutable_set_camera();
  for (const v1::ClientMessage& command : {patch, view, view, mode, cancel, camera}) {
    RawSocket socket(server.port());
    ASSERT_EQ(status_of(socket.open_websocket("/ws?token=" + std::string(RunningServer::kToken))), 101);
    v1::ClientMessage message;
    message.set_seq(1);
    message.mutable_hello()->set_protocol_major(1);
    message.mutable_hello()->set_resume_token(client.welcome().resume_token());
    socket.send_frame(message.SerializeAsString());
    bool answered = false;
    for (int i = 0; i < 50 && !answered; ++i) {
      const auto frame = socket.read_frame(4000);
      ASSERT_TRUE(frame) << command.ShortDebugString();
      v1::ServerMessage said;
      if (frame->opcode != 2 || !said.ParseFromString(frame->payload)) continue;
      if (said.has_welcome()) {
        message = command;
        message.set_seq(7);
        if (command.has_set_camera()) *message.mutable_set_camera()->mutable_camera() = said.welcome().state().camera();
        socket.send_frame(message.SerializeAsString());
      }
      answered = said.has_state() && said.heeded() == 7;
    }
    EXPECT_TRUE(answered) << command.ShortDebugString();
  }
}

TEST(Acknowledgement, OverRestTheStateComesAlsoWhereNothingChanges) {
  RunningServer server;
  const auto made = body_of(server.ask("POST", "/api/v1/sessions", R"({"dataset": "torus-12"})"));
  const std::string path = "/api/v1/sessions/" + std::string(made.at("id").as_string());
  const std::string got = server.ask("GET", path + "/state");
  const std::string text = got.substr(got.find("\r\n\r\n") + 4);  // as it came: parsed and written again its numbers may differ in the last digit
  const auto state = body_of(got);
  const std::string interval = path + "/intervals/" + json::serialize(state.at("intervals").at(0).at("id"));
  for (const auto& [method, target, body] :
       {std::tuple{std::string("PATCH"), interval, std::string(R"({"visible": true})")}, std::tuple{std::string("PUT"), path + "/state", text},
        std::tuple{std::string("POST"), path + "/commands", std::string(R"({"cancel": {"operation": 7}})")},
        std::tuple{std::string("POST"), path + "/commands", std::string(R"({"setAppearance": {}})")}}) {
    const auto answer = server.ask(method, target, body);
    EXPECT_EQ(status_of(answer), 200) << answer;
    EXPECT_EQ(body_of(answer).at("revision"), state.at("revision")) << method << " " << body;
  }
}

TEST(OpenEnds, AreSaidInJsonByWordsOrNullAndComeBack) {
  RunningServer server;
  const auto made = body_of(server.ask("POST", "/api/v1/sessions", R"({"dataset": "torus-12"})"));
  const std::string path = "/api/v1/sessions/" + std::string(made.at("id").as_string());
  const auto ends = [&](const json::value& state, std::size_t i) {
    const auto& interval = state.at("intervals").at(i);
    return json::serialize(interval.at("lower")) + ":" + json::serialize(interval.at("upper"));
  };
  const auto id = json::serialize(body_of(server.ask("GET", path + "/intervals")).at("intervals").at(0).at("id"));
  for (const auto& [body, expected] :
       {std::pair{R"({"lower": "-inf", "upper": 0.25})", R"("-Infinity":)"}, std::pair{R"({"lower": 0.25, "upper": "inf"})", R"(:"Infinity")"},
        std::pair{R"({"lower": null, "upper": null})", R"("-Infinity":"Infinity")"},
        std::pair{R"({"lower": "-Infinity", "upper": "Infinity", "surface": {"lower": null, "upper": true}})", R"("-Infinity":"Infinity")"}}) {
    const auto answer = server.ask("PATCH", path + "/intervals/" + id, body);
    ASSERT_EQ(status_of(answer), 200) << answer;
    EXPECT_TRUE(has(ends(body_of(answer), 0), expected)) << ends(body_of(answer), 0);
  }
  EXPECT_EQ(status_of(server.ask("PATCH", path + "/intervals/" + id, R"({"name": "\"lower\": \"inf\"", "lower": "-inf"})")), 200);
  const auto state = body_of(server.ask("GET", path + "/state"));
  EXPECT_EQ(state.at("intervals").at(0).at("name").as_string(), R"("lower": "inf")") << "text stays what it is";
  EXPECT_EQ(status_of(server.ask("GET", path + "/image?width=40&height=30")), 200);
  const auto again = server.ask("POST", "/api/v1/sessions", json::serialize(json::object{{"state", state}}));
  ASSERT_EQ(status_of(again), 201) << again;
  EXPECT_EQ(ends(body_of(server.ask("GET", "/api/v1/sessions/" + std::string(body_of(again).at("id").as_string()) + "/state")), 0),
            ends(state, 0));
  EXPECT_EQ(status_of(server.ask("PUT", path + "/combination",
                                 R"({"terms": [{"op": "RANGE_OPERATOR_INTERSECT", "array": "distance", "lower": 0.1, "upper": null}]})")),
            200);
  EXPECT_EQ(status_of(server.ask("GET", path + "/image?width=40&height=30")), 200);
  for (const char* wrong : {R"({"lower": "inf"})", R"({"upper": "-inf"})", R"({"lower": "NaN"})", R"({"opacity": "inf"})"})
    EXPECT_EQ(status_of(server.ask("PATCH", path + "/intervals/" + id, wrong)), 400) << wrong;
  EXPECT_TRUE(has(server.ask("GET", "/api/v1/openapi.json"), "#/components/schemas/End"));

  Client client(server.client_options());
  client.open_dataset("torus-12");
  client.move_interval(client.state().intervals(0).id(), 0.3, std::numeric_limits<double>::infinity());
  EXPECT_EQ(client.state().intervals(0).upper(), std::numeric_limits<double>::infinity());
  EXPECT_NO_THROW(client.lossless_frame());
}

}  // namespace
}  // namespace isostrata
