// The rules that all routes share, and the document that describes them.
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <set>

#include "net/answers.h"
#include "net/http/problem.h"
#include "net/rest/rest_api.h"
#include "net/running_server.h"

namespace isostrata {
namespace {

namespace json = boost::json;

/// "GET /sessions/{session}" of every route of the router.
std::set<std::string> router_routes() {
  Sessions sessions({}, [](EngineRequest) {});
  const RestApi api(sessions);
  std::set<std::string> routes;
  for (const Route& route : api.router().routes()) routes.insert(route.method + " " + route.path);
  return routes;
}

class RestRoutes : public ::testing::Test {
 protected:
  std::string ask(const std::string& method, const std::string& path, const std::string& body = "",
                  const std::string& headers = "") {
    return server_.ask(method, "/api/v1" + path, body, headers);
  }
  std::string new_session() {
    const auto response = ask("POST", "/sessions", R"({"dataset":"torus-12"})");
    EXPECT_EQ(status_of(response), 201) << response;
    return "/sessions/" + std::string(body_of(response).at("id").as_string());
  }
  void expect_problem(const std::string& response, int status, const std::string& code, const std::string& field = "") {
    EXPECT_EQ(status_of(response), status) << response;
    EXPECT_EQ(header_of(response, "Content-Type"), "application/problem+json") << response;
    const auto problem = body_of(response);
    EXPECT_EQ(problem.at("code").as_string(), code) << response;
    EXPECT_EQ(problem.at("status").to_number<int>(), status) << response;
    EXPECT_EQ(problem.at("title").as_string(), status_phrase(status));
    if (!field.empty()) {
      EXPECT_EQ(problem.at("field").as_string(), field) << response;
    }
  }
  RunningServer server_;
};

TEST_F(RestRoutes, TheDocumentNamesEveryRouteAndNoOther) {
  const json::value document = body_of(ask("GET", "/openapi.json"));
  EXPECT_EQ(document.at("openapi").as_string(), "3.1.0");
  std::set<std::string> described;
  std::set<std::string> ids;
  for (const auto& [path, methods] : document.at("paths").as_object())
    for (const auto& [method, operation] : methods.as_object()) {
      std::string upper(method);
      for (char& c : upper) c = static_cast<char>(std::toupper(c));
      described.insert(upper + " " + std::string(path));
      EXPECT_TRUE(ids.insert(std::string(operation.at("operationId").as_string())).second) << path;
    }
  EXPECT_EQ(described, router_routes());
}

TEST_F(RestRoutes, EveryDescribedRouteIsAnsweredByItsHandler) {
  // Whatever a route says to nothing at all, it is not that there is no such route or method.
  const std::string session = new_session();
  for (const std::string& route : router_routes()) {
    const auto space = route.find(' ');
    std::string path = route.substr(space + 1);
    if (route == "DELETE /sessions/{session}") continue;
    for (const auto& [name, value] : std::map<std::string, std::string>{{"/sessions/{session}", session},
                                                                        {"{dataset}", "torus-12"},
                                                                        {"{interval}", "1"},
                                                                        {"{operation}", "r0"},
                                                                        {"{export}", "r0"}})
      if (const auto at = path.find(name); at != std::string::npos) path.replace(at, name.size(), value);
    const auto response = ask(route.substr(0, space), path);
    EXPECT_NE(status_of(response), 405) << route;
    EXPECT_FALSE(has(response, "no such route")) << route;
    EXPECT_LT(status_of(response), 500) << route << "\n" << response;
  }
}

TEST_F(RestRoutes, OtherMethodsAreRefusedWithThoseThatAreAllowed) {
  const std::string session = new_session();
  const auto refused = ask("POST", session + "/state", "{}");
  expect_problem(refused, 405, "unsupported");
  EXPECT_EQ(header_of(refused, "Allow"), "GET, HEAD, PUT, PATCH, OPTIONS");
  const auto options = ask("OPTIONS", "/datasets/x/histogram");
  EXPECT_EQ(status_of(options), 204) << options;
  EXPECT_EQ(header_of(options, "Allow"), "GET, HEAD, OPTIONS");
  expect_problem(ask("BREW", "/datasets"), 405, "unsupported");
}

TEST_F(RestRoutes, HeadIsGetWithoutItsBody) {
  const std::string session = new_session();
  const auto get = ask("GET", session + "/state"), head = ask("HEAD", session + "/state");
  EXPECT_EQ(status_of(head), 200);
  EXPECT_EQ(header_of(head, "ETag"), header_of(get, "ETag"));
  EXPECT_EQ(header_of(head, "Content-Length"), header_of(get, "Content-Length"));
  EXPECT_TRUE(text_of(head).empty());
}

TEST_F(RestRoutes, BodiesOfOtherTypesAreRefused) {
  const std::string session = new_session();
  for (const std::string type :
       {"application/x-www-form-urlencoded", "text/plain;charset=UTF-8", "multipart/form-data; boundary=x"})
    expect_problem(ask("POST", session + "/intervals", R"({"lower":0,"upper":1})", "Content-Type: " + type + "\r\n"), 415,
                   "unsupported", "Content-Type");
  for (const std::string type : {"application/json", "application/json; charset=utf-8", "application/merge-patch+json"})
    EXPECT_EQ(status_of(ask("PATCH", session + "/state", "{}", "Content-Type: " + type + "\r\n")), 200) << type;
}

TEST_F(RestRoutes, BodiesAreReadStrictly) {
  const std::string state = new_session() + "/state", before = text_of(ask("GET", state));
  std::string deep = R"({"camera":)";
  for (int i = 0; i < 200; ++i) deep += R"({"eye":)";
  for (const std::string& body :
       {std::string("{"), std::string("[]"), std::string("null"), std::string("{} {}"),
        std::string(R"({"unitDistance":1,"unitDistance":2})"), std::string(R"({"camera":{"fovDeg":1,"fovDeg":2}})"),
        std::string(R"({"nosuch":1})"), std::string(R"({"unitDistance":"x"})"), std::string(R"({"step":1.5})"),
        std::string(R"({"step":99999999999})"), std::string(R"({"mode":"RENDER_MODE_NONE"})"),
        std::string("{\"array\":\"\xff\"}"), std::string("{\"array\":\"\\ud800\"}"), std::string(1000, '['), deep,
        std::string("{\"unitDistance\":NaN}"), std::string("\0", 1)})
    expect_problem(ask("PATCH", state, body), 400, "malformed");
  expect_problem(ask("PATCH", state, R"({"unitDistance":1,"unitDistance":2})"), 400, "malformed", "unitDistance");
  expect_problem(ask("PATCH", state), 400, "malformed");
  for (const auto& [body, field] : std::map<std::string, std::string>{{R"({"unitDistance":-1})", "unit_distance"},
                                                                      {R"({"unitDistance":"NaN"})", "unit_distance"},
                                                                      {R"({"background":{"r":7}})", "background.r"},
                                                                      {R"({"mode":99})", "mode"}})
    EXPECT_EQ(body_of(ask("PATCH", state, body)).at("field").as_string(), field) << body;
  EXPECT_EQ(text_of(ask("GET", state)), before) << "what was refused has changed something";
}

TEST_F(RestRoutes, UnknownAndRepeatedQueryParametersAreRefused) {
  const std::string image = new_session() + "/image";
  expect_problem(ask("GET", image + "?widht=10"), 400, "invalid_argument", "widht");
  expect_problem(ask("GET", image + "?width=10&width=20"), 400, "malformed");
  for (const std::string bad : {"-1", "1e3", "0x10", "", "99999999999", "%00"})
    EXPECT_EQ(status_of(ask("GET", image + "?width=" + bad)), 400) << bad;
}

TEST_F(RestRoutes, IfMatchGuardsEveryChange) {
  const std::string session = new_session();
  const auto tag = header_of(ask("GET", session + "/state"), "ETag");
  const std::map<std::string, std::pair<std::string, std::string>> changes = {
      {"/state", {"PATCH", R"({"unitDistance":0.5})"}},
      {"/intervals", {"POST", R"({"lower":0.1,"upper":0.2})"}},
      {"/intervals/1", {"PATCH", R"({"opacity":0.5})"}},
      {"/clip-planes", {"PUT", R"({"clipPlanes":[{"normal":{"x":1}}]})"}},
      {"/view", {"PUT", R"({"view":"+y"})"}},
      {"/commands", {"POST", R"({"setView":{"view":"-x"}})"}},
  };
  EXPECT_EQ(status_of(ask("PUT", session + "/view", R"({"view":"+z"})", "If-Match: \"x\", " + tag + "\r\n")), 200);
  for (const auto& [path, change] : changes) {
    const auto stale = ask(change.first, session + path, change.second, "If-Match: " + tag + "\r\n");
    expect_problem(stale, 412, "precondition_failed", "If-Match");
    const auto now = header_of(ask("GET", session + "/state"), "ETag");
    EXPECT_EQ(header_of(stale, "ETag"), now);
    for (const std::string& bad : {"W/" + now, std::string("2"), std::string("\"\""), std::string()})
      EXPECT_EQ(status_of(ask(change.first, session + path, change.second, "If-Match: " + bad + "\r\n")), 412) << bad;
    EXPECT_LT(status_of(ask(change.first, session + path, change.second, "If-Match: " + now + "\r\n")), 300) << path;
  }
  EXPECT_EQ(status_of(ask("PUT", session + "/view", R"({"view":"+x"})", "If-Match: *\r\n")), 200);
}

TEST_F(RestRoutes, WhatAPartAnswersItTakesBack) {
  const std::string session = new_session();
  ASSERT_EQ(status_of(ask("PUT", session + "/clip-planes", R"({"clipPlanes":[{"normal":{"x":1},"offset":0.25}]})")), 200);
  for (const auto& [path, method] : std::map<std::string, std::string>{{"selection", "PATCH"},
                                                                       {"time-step", "PUT"},
                                                                       {"priorities", "PUT"},
                                                                       {"combination", "PUT"},
                                                                       {"camera", "PUT"},
                                                                       {"appearance", "PATCH"},
                                                                       {"cycle", "PATCH"},
                                                                       {"smear", "PUT"},
                                                                       {"clip-planes", "PUT"},
                                                                       {"annotations", "PUT"},
                                                                       {"intervals", "PUT"},
                                                                       {"time", "PATCH"}}) {
    const auto before = text_of(ask("GET", session + "/state"));
    const auto part = ask("GET", session + "/" + path);
    ASSERT_EQ(status_of(part), 200) << part;
    const auto put = ask(method, session + "/" + path, text_of(part));
    EXPECT_EQ(status_of(put), 200) << path << put;
    EXPECT_EQ(text_of(put), before) << path;
  }
}

TEST_F(RestRoutes, ASavedStateBeginsAnotherSession) {
  const std::string session = new_session();
  ASSERT_EQ(status_of(ask("POST", session + "/intervals", R"({"lower":0.1,"upper":0.30000000000000004,"name":"mine"})")), 201);
  ASSERT_EQ(status_of(ask("PUT", session + "/view", R"({"view":"-z"})")), 200);
  const auto saved = text_of(ask("GET", session + "/state"));
  const auto created = ask("POST", "/sessions", "{\"state\":" + saved + "}");
  ASSERT_EQ(status_of(created), 201) << created;
  auto again = body_of(ask("GET", "/sessions/" + std::string(body_of(created).at("id").as_string()) + "/state"));
  auto before = json::parse(saved);
  for (json::value* state : {&again, &before}) {
    state->as_object().erase("revision");
    for (json::value& interval : state->at("intervals").as_array()) interval.as_object().erase("id");
  }
  EXPECT_EQ(again, before);
  expect_problem(ask("POST", "/sessions", R"({"state":{"dataset":"torus-12","intervals":[{"lower":2,"upper":1}]}})"), 400,
                 "invalid_argument", "intervals[0].lower");
}

TEST_F(RestRoutes, APictureIsTheSameForTheSameRevision) {
  const std::string session = new_session();
  for (const std::string format : {"png", "jpeg", "webp", "exr"}) {
    const std::string path = session + "/image?width=40&height=30&format=" + format;
    const auto first = ask("GET", path), second = ask("GET", path);
    ASSERT_EQ(status_of(first), 200) << first;
    EXPECT_EQ(header_of(first, "Content-Type"), format == "exr" ? "image/x-exr" : "image/" + format);
    EXPECT_EQ(text_of(first), text_of(second)) << format;
    const auto tag = header_of(first, "ETag");
    EXPECT_EQ(status_of(ask("GET", path, "", "If-None-Match: " + tag + "\r\n")), 304);
    EXPECT_EQ(status_of(ask("GET", path, "", "If-Match: \"0\"\r\n")), 412);
  }
  expect_problem(ask("GET", session + "/image?format=exr&width=8192&height=8192"), 413, "too_large", "width");
  expect_problem(ask("GET", session + "/image?format=webp&width=16384&height=1"), 413, "too_large", "width");
}

TEST_F(RestRoutes, StatisticsAreThoseOfTheArray) {
  const auto whole = ask("GET", "/datasets/torus-12/statistics?array=distance");
  const auto s = body_of(whole);
  EXPECT_EQ(s.at("finite").to_number<int>(), 1728);
  EXPECT_LT(s.at("lower").to_number<double>(), s.at("mean").to_number<double>());
  EXPECT_LT(s.at("mean").to_number<double>(), s.at("upper").to_number<double>());
  EXPECT_GT(s.at("standardDeviation").to_number<double>(), 0);
  const std::string session = new_session();
  EXPECT_EQ(text_of(ask("GET", session + "/statistics")), text_of(whole));
  expect_problem(ask("GET", session + "/statistics?array=nosuch"), 404, "not_found", "array");
}

TEST_F(RestRoutes, LayersHoldTheSolidsVolumeAndSayHowSureItIs) {
  const std::string session = new_session();
  const auto layers = body_of(ask("GET", session + "/layers")).at("intervals").as_array();
  const auto shown = body_of(ask("GET", session + "/intervals")).at("intervals").as_array();
  ASSERT_EQ(layers.size(), shown.size());
  ASSERT_FALSE(layers.empty());
  EXPECT_EQ(layers[0].at("id"), shown[0].at("id"));
  const double volume = layers[0].at("volume").to_number<double>(), error = layers[0].at("volumeError").to_number<double>();
  EXPECT_GT(volume, 0);
  EXPECT_LT(volume, 8);
  EXPECT_GT(error, 0) << "hexahedra";
  EXPECT_LT(error, 0.2 * volume);
}

TEST(RestLayers, OfAFlatGridHaveAnAreaInPlaceOfAVolume) {
  ServerOptions options;
  options.engine.catalogue = Catalogue::from_sources({"diamond:8"});
  RunningServer server(std::move(options));
  const auto made = body_of(server.ask("POST", "/api/v1/sessions", R"({"dataset": "diamond-8"})"));
  const auto layers = body_of(server.ask("GET", "/api/v1/sessions/" + std::string(made.at("id").as_string()) + "/layers"));
  double area = 0;
  for (const auto& layer : layers.at("intervals").as_array()) {
    area += layer.at("area").to_number<double>();
    EXPECT_FALSE(layer.as_object().contains("volumeError"));
  }
  EXPECT_GT(area, 0);
}

TEST_F(RestRoutes, RequestsHaveNames) {
  const auto given = ask("GET", "/datasets", "", "X-Request-Id: run-7.b_2\r\n");
  EXPECT_EQ(header_of(given, "X-Request-Id"), "run-7.b_2");
  std::set<std::string> made;
  for (const std::string bad : {"", "X-Request-Id: a b\r\n", "X-Request-Id: \x80\r\n"})
    EXPECT_TRUE(made.insert(header_of(ask("GET", "/datasets", "", bad), "X-Request-Id")).second);
  EXPECT_FALSE(made.contains(""));
}

}  // namespace
}  // namespace isostrata
