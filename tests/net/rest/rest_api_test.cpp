#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>

#include "net/running_server.h"

namespace isostrata {
namespace {

namespace json = boost::json;

class Rest : public ::testing::Test {
 protected:
  json::value body(const std::string& response) {
    const auto at = response.find("\r\n\r\n");
    boost::system::error_code error;
    json::value value = json::parse(response.substr(at + 4), error);
    EXPECT_FALSE(error) << response;
    return value;
  }
  json::value get(const std::string& path) { return body(server_.ask("GET", "/api/v1/" + path)); }
  std::string new_session(const std::string& dataset = "torus-12") {
    const auto response = server_.ask("POST", "/api/v1/sessions", "{\"dataset\":\"" + dataset + "\"}");
    EXPECT_EQ(status_of(response), 201) << response;
    return std::string(body(response).at("id").as_string());
  }
  void expect_problem(const std::string& response, int status, const std::string& code, const std::string& field = "") {
    EXPECT_EQ(status_of(response), status) << response;
    EXPECT_TRUE(has(response, "application/problem+json")) << response;
    const auto problem = body(response);
    EXPECT_EQ(problem.at("code").as_string(), code) << response;
    if (!field.empty()) {
      EXPECT_EQ(problem.at("field").as_string(), field) << response;
    }
    EXPECT_FALSE(problem.at("detail").as_string().empty());
  }
  RunningServer server_;
};

TEST_F(Rest, DatasetsAreListedAndDescribedWithoutTheirPaths) {
  EXPECT_EQ(get("datasets").at("datasets").as_array().size(), 2u);
  const auto info = get("datasets/torus-12");
  EXPECT_EQ(info.at("points").as_string(), "1728");
  EXPECT_EQ(info.at("arrays").at(0).at("name").as_string(), "distance");
  expect_problem(server_.ask("GET", "/api/v1/datasets/%2Fetc%2Fpasswd"), 400, "malformed");
  expect_problem(server_.ask("GET", "/api/v1/datasets/nosuch"), 404, "not_found");
}

TEST_F(Rest, AHistogramCountsEveryPoint) {
  const auto histogram = get("datasets/torus-12/histogram?array=distance&bins=7");
  std::int64_t sum = 0;
  for (const auto& count : histogram.at("counts").as_array()) sum += std::stoll(std::string(count.as_string()));
  EXPECT_EQ(sum, 1728);
  expect_problem(server_.ask("GET", "/api/v1/datasets/torus-12/histogram?bins=0"), 400, "invalid_argument", "bins");
  expect_problem(server_.ask("GET", "/api/v1/datasets/torus-12/histogram?bins=x"), 400, "invalid_argument", "bins");
  expect_problem(server_.ask("GET", "/api/v1/datasets/torus-12/histogram?step=4"), 404, "not_found", "step");
}

TEST_F(Rest, WhatLiesAtAPlaceIsLookedUpInTheData) {
  const std::string session = "sessions/" + new_session(), path = "/api/v1/" + session + "/probe";
  EXPECT_EQ(status_of(server_.ask("PUT", "/api/v1/" + session + "/view", R"({"view":"+z"})")), 200);
  EXPECT_EQ(status_of(server_.ask("PUT", "/api/v1/" + session + "/intervals", R"({"intervals":[{"lower":0.1,"upper":0.3,"opacity":0.5,"visible":true}]})")), 200);
  int hits = 0;
  for (const char* x : {"0.1", "0.3", "0.35", "0.4", "0.6"}) {
    const json::value found = get(session + "/probe?x=" + x + "&y=0.5&width=400&height=300");
    const auto* hit = found.as_object().if_contains("hit");
    if (!hit || !hit->as_bool()) {
      EXPECT_FALSE(found.at("miss").as_string().empty());
      continue;
    }
    ++hits;
    const double value = found.at("arrays").at(0).at("value").to_number<double>();
    EXPECT_EQ(found.at("arrays").at(0).at("name").as_string(), "distance");
    EXPECT_GE(value, 0.1 - 1e-6);
    EXPECT_LE(value, 0.3 + 1e-6);
    EXPECT_EQ(found.at("cellIndex").as_array().size(), 3u);
  }
  EXPECT_GT(hits, 1);
  expect_problem(server_.ask("GET", path + "?y=0.5"), 400, "invalid_argument", "x");
  expect_problem(server_.ask("GET", path + "?x=0.5&y=1.5"), 400, "invalid_argument", "y");
  expect_problem(server_.ask("GET", path + "?x=nan&y=0.5"), 400, "invalid_argument", "x");
  expect_problem(server_.ask("GET", path + "?x=0.5&y=0.5&width=0"), 400, "invalid_argument", "width");
}

TEST_F(Rest, ValuesAlongALineAreThoseOfTheData) {
  const std::string session = "sessions/" + new_session(), path = "/api/v1/" + session + "/probe/line";
  EXPECT_EQ(status_of(server_.ask("PUT", "/api/v1/" + session + "/intervals", R"({"intervals":[{"lower":0.1,"upper":0.3,"opacity":0.5,"visible":true}]})")), 200);
  const json::value found = get(session + "/probe/line?from=-2,0,0&to=2,0.0,0e0&array=distance");
  EXPECT_EQ(found.at("array").as_string(), "distance");
  const json::array &at = found.at("at").as_array(), &values = found.at("value").as_array();
  ASSERT_EQ(at.size(), values.size());
  ASSERT_GT(at.size(), 11u);
  EXPECT_NEAR(at.front().to_number<double>(), 1, 1e-6) << "where the data begins";
  for (std::size_t i = 0; i < at.size(); ++i)
    EXPECT_NEAR(values[i].to_number<double>(), std::abs(std::abs(at[i].to_number<double>() - 2) - 0.6), 0.15);
  EXPECT_GE(found.at("layers").as_array().size(), 2u) << "the tube is met twice";
  expect_problem(server_.ask("GET", path + "?to=1,0,0"), 400, "invalid_argument", "from");
  expect_problem(server_.ask("GET", path + "?from=0,0&to=1,0,0"), 400, "invalid_argument", "from");
  expect_problem(server_.ask("GET", path + "?from=0,0,0,0&to=1,0,0"), 400, "invalid_argument", "from");
  expect_problem(server_.ask("GET", path + "?from=0,0,0&to=inf,0,0"), 400, "invalid_argument", "to");
  expect_problem(server_.ask("GET", path + "?from=0,0,0&to=0,0,0"), 400, "invalid_argument", "to");
  expect_problem(server_.ask("GET", path + "?from=0,0,0&to=1,0,0&array=none"), 404, "not_found", "array");
  expect_problem(server_.ask("GET", "/api/v1/" + session + "/probe/steps?at=0,0,0"), 400, "invalid_argument", "at");
}

TEST_F(Rest, ALayerIsToldInNumbers) {
  const std::string session = "sessions/" + new_session();
  EXPECT_EQ(status_of(server_.ask("PUT", "/api/v1/" + session + "/intervals", R"({"intervals":[{"lower":0.1,"upper":0.3,"opacity":0.5,"visible":true}]})")), 200);
  const json::value interval = get(session + "/intervals").at("intervals").at(0);
  const std::string path = session + "/intervals/" + std::to_string(interval.at("id").to_number<int>()) + "/statistics";
  const json::value found = get(path + "?array=distance");
  const json::value layer = get(session + "/layers").at("intervals").at(0);
  EXPECT_NEAR(found.at("volume").to_number<double>(), layer.at("volume").to_number<double>(), 1e-6);
  EXPECT_GT(found.at("mean").to_number<double>(), 0.1);
  EXPECT_LT(found.at("mean").to_number<double>(), 0.3);
  EXPECT_EQ(found.at("pieces").as_string(), "1");
  expect_problem(server_.ask("GET", "/api/v1/" + path + "?array=none"), 404, "not_found", "array");
  expect_problem(server_.ask("GET", "/api/v1/" + session + "/intervals/999/statistics"), 404, "not_found", "id");
}

TEST_F(Rest, AStateThatWasReadCanBeWrittenBack) {
  const std::string path = "/api/v1/sessions/" + new_session() + "/state";
  const auto text = [](const std::string& response) { return response.substr(response.find("\r\n\r\n") + 4); };
  const auto state = text(server_.ask("GET", path));
  const auto put = server_.ask("PUT", path, state);
  EXPECT_EQ(status_of(put), 200) << put;
  EXPECT_EQ(text(put), state);
  EXPECT_EQ(text(server_.ask("PATCH", path, "{}")), state) << "an empty patch changes nothing, not even a last bit";
}

TEST_F(Rest, APatchChangesWhatItNames) {
  const std::string path = "/api/v1/sessions/" + new_session() + "/state";
  const auto patched = body(server_.ask("PATCH", path, R"({"mode":"RENDER_MODE_PRIORITIZED","unitDistance":0.25})"));
  EXPECT_EQ(patched.at("mode").as_string(), "RENDER_MODE_PRIORITIZED");
  EXPECT_EQ(patched.at("intervals"), body(server_.ask("GET", path)).at("intervals")) << "and nothing else";
  const auto moved = body(server_.ask("PATCH", path, R"({"dataset":"tets-6"})"));
  EXPECT_EQ(moved.at("dataset").as_string(), "tets-6");
  expect_problem(server_.ask("PATCH", path, R"({"nonsense":1})"), 400, "malformed");
  expect_problem(server_.ask("PATCH", path, "[1]"), 400, "malformed");
  expect_problem(server_.ask("PATCH", path, R"({"camera":{"fovDeg":0}})"), 400, "invalid_argument", "camera");
}

TEST_F(Rest, AStaleWriterIsTold) {
  const std::string path = "/api/v1/sessions/" + new_session() + "/state";
  EXPECT_EQ(status_of(server_.ask("PATCH", path, R"({"unitDistance":0.5})", "If-Match: \"2\"\r\n")), 200);
  EXPECT_EQ(status_of(server_.ask("PATCH", path, R"({"unitDistance":0.7})", "If-Match: \"2\"\r\n")), 412);
}

TEST_F(Rest, IntervalsAreAddedChangedAndRemoved) {
  const std::string path = "/api/v1/sessions/" + new_session() + "/intervals";
  const auto added = server_.ask("POST", path, R"({"lower":0.2,"upper":0.3,"color":{"r":1}})");
  ASSERT_EQ(status_of(added), 201) << added;
  const json::value state = body(added);
  const json::value& last = state.at("intervals").as_array().back();
  EXPECT_TRUE(last.at("visible").as_bool());
  const std::string one = path + "/" + std::to_string(last.at("id").to_number<int>());
  EXPECT_EQ(status_of(server_.ask("PATCH", one, R"({"upper":0.4})")), 200);
  EXPECT_EQ(body(server_.ask("GET", one)).at("upper").to_number<double>(), 0.4);
  expect_problem(server_.ask("PATCH", one, R"({"lower":0.4})"), 400, "invalid_argument", "lower");
  EXPECT_EQ(status_of(server_.ask("DELETE", one)), 200);
  expect_problem(server_.ask("GET", one), 404, "not_found", "id");
}

TEST_F(Rest, SurfacesAndModesAreSetLikeEverythingElse) {
  const std::string session = "/api/v1/sessions/" + new_session();
  const std::string one = session + "/intervals/1";
  ASSERT_EQ(status_of(server_.ask("PATCH", one, R"({"surface":{"upper":true,"silhouette":0.5},"opacityUpper":0.9})")), 200);
  const auto interval = body(server_.ask("GET", one));
  EXPECT_TRUE(interval.at("surface").at("upper").as_bool());
  EXPECT_EQ(interval.at("opacityUpper").to_number<double>(), 0.9);
  ASSERT_EQ(status_of(server_.ask("PATCH", one, R"({"opacityUpper":null})")), 200);
  EXPECT_FALSE(body(server_.ask("GET", one)).as_object().contains("opacityUpper"));
  expect_problem(server_.ask("PATCH", one, R"({"surface":{"opacity":7}})"), 400, "invalid_argument", "surface.opacity");
  const auto state =
      body(server_.ask("PATCH", session + "/state", R"({"mode":"RENDER_MODE_CYCLED","cycle":{"seconds":2,"playing":false}})"));
  EXPECT_EQ(state.at("cycle").at("seconds").to_number<double>(), 2);
  expect_problem(server_.ask("POST", session + "/commands", R"({"setSmear":{"smear":{"steps":[5]}}})"), 404, "not_found",
                 "steps[0]");
}

TEST_F(Rest, AnImageIsThePictureOfItsRevision) {
  const std::string path = "/api/v1/sessions/" + new_session() + "/image";
  const auto response = server_.ask("GET", path + "?width=33&height=21");
  ASSERT_EQ(status_of(response), 200);
  const auto picture = client::decode(response.substr(response.find("\r\n\r\n") + 4));
  EXPECT_EQ(picture.width, 33);
  EXPECT_EQ(picture.height, 21);
  EXPECT_EQ(picture.rgb[2], 77);
  EXPECT_TRUE(has(server_.ask("GET", path + "?format=jpeg"), "image/jpeg"));
  expect_problem(server_.ask("GET", path + "?width=0"), 400, "invalid_argument", "width");
  expect_problem(server_.ask("GET", path + "?width=16384&height=16384"), 413, "too_large", "width");
  expect_problem(server_.ask("GET", path + "?format=gif"), 400, "invalid_argument", "format");
  server_.control->fail = true;
  expect_problem(server_.ask("GET", path), 503, "unavailable");
  server_.control->fail = false;
  EXPECT_EQ(status_of(server_.ask("GET", path)), 200);
}

TEST_F(Rest, WhatAScriptDoesABrowserSees) {
  client::Client browser(server_.client_options());
  browser.open_dataset("torus-12");
  const auto revision = browser.state().revision();
  const std::string path =
      "/api/v1/sessions/" + browser.welcome().session() + "/intervals/" + std::to_string(browser.state().intervals(0).id());
  EXPECT_EQ(status_of(server_.ask("PATCH", path, R"({"opacity":0.125})")), 200);
  for (int i = 0; i < 50 && browser.state().revision() <= revision; ++i) browser.receive(std::chrono::milliseconds(200));
  EXPECT_EQ(browser.state().intervals(0).opacity(), 0.125);
  EXPECT_EQ(browser.lossless_frame().revision(), browser.state().revision());
}

TEST_F(Rest, ACommandIsTheSameMessage) {
  const std::string path = "/api/v1/sessions/" + new_session() + "/commands";
  EXPECT_EQ(body(server_.ask("POST", path, R"({"setView":{"view":"+x"}})")).at("camera").at("up").at("x").to_number<double>(), 0);
  expect_problem(server_.ask("POST", path, R"({"setView":{"view":"?"}})"), 400, "invalid_argument", "view");
  expect_problem(server_.ask("POST", path, R"({"frameAck":{}})"), 422, "unsupported");
  expect_problem(server_.ask("POST", path, "{"), 400, "malformed");
}

TEST_F(Rest, WhatIsNotThereAndWhatIsNotDone) {
  expect_problem(server_.ask("GET", "/api/v1/nosuch"), 404, "not_found");
  expect_problem(server_.ask("GET", "/api/v1/sessions/0/state"), 404, "not_found");
  expect_problem(server_.ask("POST", "/api/v1/sessions", R"({"dataset":"nosuch"})"), 404, "not_found");
  expect_problem(server_.ask("DELETE", "/api/v1/datasets"), 405, "unsupported");
  const std::string id = new_session();
  EXPECT_EQ(status_of(server_.ask("DELETE", "/api/v1/sessions/" + id)), 204);
  expect_problem(server_.ask("GET", "/api/v1/sessions/" + id), 404, "not_found");
}

TEST_F(Rest, ASessionWhoseDatasetCannotBeOpenedIsNotLeftBehind) {
  for (int i = 0; i < 50; ++i)
    expect_problem(server_.ask("POST", "/api/v1/sessions", R"({"dataset":"nosuch"})"), 404, "not_found");
  EXPECT_TRUE(get("sessions").at("sessions").as_array().empty());
}

TEST(RestOpening, ASessionMayBeDeletedWhileItsDatasetIsBeingOpened) {
  ServerOptions options;
  options.engine.catalogue = Catalogue::from_sources({"cylinder:160x160x80", "torus:8"});
  RunningServer server(std::move(options));
  const std::string body = R"({"dataset":"cylinder-160x160x80"})";
  RawSocket creating(server.port());
  creating.send(std::string("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer ") +
                RunningServer::kToken + "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  std::string id;
  for (int i = 0; i < 500 && id.empty(); ++i) {
    const std::string listed = server.ask("GET", "/api/v1/sessions");
    if (const auto at = listed.find("\"id\":\""); at != std::string::npos)
      id = listed.substr(at + 6, listed.find('"', at + 6) - at - 6);
  }
  ASSERT_FALSE(id.empty());
  EXPECT_EQ(status_of(server.ask("DELETE", "/api/v1/sessions/" + id)), 204);
  const std::string answer = creating.read_response();
  // On a machine that opens it faster than a second request comes, it was there before it was deleted.
  EXPECT_TRUE(status_of(answer) == 404 || status_of(answer) == 201) << answer;
  EXPECT_EQ(status_of(server.ask("GET", "/api/v1/sessions/" + id)), 404);
  EXPECT_EQ(status_of(server.ask("POST", "/api/v1/sessions", R"({"dataset":"torus-8"})")), 201);
}

TEST(RestOpening, AFileThatIsGoneIsNamedWithoutItsPlaceOnTheServer) {
  testing::TemporaryFolder scratch;
  scratch.write("deep/gone.vtk", "x");
  ServerOptions options;
  options.engine.catalogue = Catalogue::from_sources({scratch.path().string()});
  const std::string id = options.engine.catalogue.entries().at(0).id;
  RunningServer server(std::move(options));
  std::filesystem::remove(scratch.path() / "deep" / "gone.vtk");
  const std::string answer = server.ask("POST", "/api/v1/sessions", "{\"dataset\":\"" + id + "\"}");
  EXPECT_EQ(status_of(answer), 404) << answer;
  EXPECT_TRUE(has(answer, "deep/gone.vtk")) << answer;
  EXPECT_FALSE(has(answer, scratch.path().string())) << answer;
}

}  // namespace
}  // namespace isostrata
