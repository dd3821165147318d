// Long work over REST: exports, progress as events, cancel.
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <thread>

#include "net/answers.h"
#include "net/running_server.h"

namespace isostrata {
namespace {

namespace json = boost::json;

class RestOperations : public ::testing::Test {
 protected:
  static ServerOptions with_large_data() {
    ServerOptions options;
    options.engine.catalogue = Catalogue::from_sources({"torus:12", "cylinder:160x160x80", "torus:200"});
    return options;
  }
  std::string ask(const std::string& method, const std::string& path, const std::string& body = "",
                  const std::string& headers = "") {
    return server_.ask(method, "/api/v1" + path, body, headers);
  }
  json::value get(const std::string& path) { return json::parse(text_of(ask("GET", path))); }
  std::string new_session(const std::string& dataset) {
    return "/sessions/" +
           std::string(json::parse(text_of(ask("POST", "/sessions", "{\"dataset\":\"" + dataset + "\"}"))).at("id").as_string());
  }
  /// Follows the operation's events to their end.
  std::string events(const std::string& operation) { return ask("GET", operation + "/events"); }
  std::string begin(const std::string& session, const std::string& body) {
    const auto response = ask("POST", session + "/exports", body);
    EXPECT_EQ(status_of(response), 202) << response;
    return std::string(json::parse(text_of(response)).at("id").as_string());
  }

  RunningServer server_{with_large_data()};
};

TEST_F(RestOperations, AnExportIsAFileThatCanBeFetchedUntilItIsDeleted) {
  const std::string session = new_session("torus-12");
  for (const std::string format : {"vtu", "vtkhdf", "ply", "stl"}) {
    const std::string id = begin(session, "{\"format\":\"" + format + "\"}");
    const auto told = events(session + "/operations/" + id);
    EXPECT_TRUE(has(told, "event: done\ndata: {")) << told;
    EXPECT_TRUE(has(told, "Content-Type: text/event-stream")) << told;
    const auto done = get(session + "/operations/" + id);
    EXPECT_EQ(done.at("status").as_string(), "done");
    const std::string href = "/" + std::string(done.at("result").at("href").as_string());
    const auto file = ask("GET", href);
    ASSERT_EQ(status_of(file), 200) << file.substr(0, 300);
    EXPECT_EQ(text_of(file).size(), done.at("result").at("bytes").to_number<std::size_t>());
    EXPECT_TRUE(text_of(file).starts_with(format == "vtu" ? "<?xml" : format == "vtkhdf" ? "\x89HDF" : format == "ply" ? "ply" : "")) << format;
    EXPECT_TRUE(has(file, "attachment; filename=\"layers-"));
    const auto head = ask("HEAD", href);
    EXPECT_TRUE(has(head, "Content-Length: " + std::to_string(text_of(file).size()))) << head;
    EXPECT_TRUE(text_of(head).empty());
    EXPECT_EQ(status_of(ask("DELETE", href)), 204);
    EXPECT_EQ(status_of(ask("GET", href)), 404);
  }
}

TEST_F(RestOperations, ExportsThatMakeNoSenseAreRefused) {
  const std::string session = new_session("torus-12");
  for (const std::string body :
       {R"({})", R"({"format":"obj"})", R"({"format":"../../etc/passwd"})", R"({"format":"vtu","compression":10})",
        R"({"format":"stl","facets":["left"]})", R"({"format":"stl","facets":["lower","lower","lower","lower"]})"}) {
    const auto response = ask("POST", session + "/exports", body);
    EXPECT_EQ(status_of(response), 400) << body << response;
    EXPECT_TRUE(has(response, "\"field\":")) << response;
  }
  ASSERT_EQ(status_of(ask("PUT", session + "/intervals", R"({"intervals":[]})")), 200);
  EXPECT_EQ(status_of(ask("POST", session + "/exports", R"({"format":"vtu"})")), 404);
}

TEST_F(RestOperations, ASessionKeepsFourExports) {
  const std::string session = new_session("torus-12");
  std::string last;
  for (int i = 0; i < 4; ++i) last = begin(session, R"({"format":"stl","facets":["upper"]})");
  const auto fifth = ask("POST", session + "/exports", R"({"format":"stl"})");
  EXPECT_EQ(status_of(fifth), 503) << fifth;
  events(session + "/operations/" + last);
  EXPECT_EQ(status_of(ask("DELETE", session + "/exports/" + last)), 204);
  EXPECT_EQ(status_of(ask("POST", session + "/exports", R"({"format":"stl"})")), 202);
}

TEST_F(RestOperations, AnExportCanBeCancelled) {
  const std::string session = new_session("torus-200");
  ASSERT_EQ(status_of(ask("PUT", session + "/intervals", R"({"intervals":[{"lower":-1,"upper":2,"visible":false}]})")), 200);
  const std::string operation = session + "/operations/" + begin(session, R"({"format":"vtu","compression":9})");
  const auto cancelled = ask("DELETE", operation);
  EXPECT_EQ(status_of(cancelled), 202) << cancelled;
  EXPECT_TRUE(has(events(operation), "event: cancelled\n"));
  EXPECT_EQ(get(operation).at("error").at("code").as_string(), "cancelled");
  EXPECT_EQ(status_of(ask("DELETE", operation)), 204);
  EXPECT_EQ(status_of(ask("GET", operation)), 404);
}

TEST_F(RestOperations, ADatasetMayBeOpenedWithoutWaiting) {
  const std::string session = new_session("torus-12");
  const auto accepted = ask("PUT", session + "/dataset", R"({"id":"cylinder-160x160x80"})", "Prefer: respond-async\r\n");
  ASSERT_EQ(status_of(accepted), 202) << accepted;
  const auto operation = session + "/operations/" + std::string(json::parse(text_of(accepted)).at("id").as_string());
  const auto told = events(operation);
  EXPECT_TRUE(has(told, "event: progress\n")) << told;
  EXPECT_TRUE(has(told, "event: done\n")) << told;
  EXPECT_EQ(get(session + "/state").at("dataset").as_string(), "cylinder-160x160x80");
  EXPECT_EQ(get(session + "/dataset").at("grid").as_string(), "curvilinear");
  // What is open already needs no operation; what does not exist fails as one.
  EXPECT_EQ(status_of(ask("PUT", session + "/dataset", R"({"id":"cylinder-160x160x80"})", "Prefer: respond-async\r\n")), 200);
  const auto missing = ask("PUT", session + "/dataset", R"({"id":"nosuch"})", "Prefer: respond-async\r\n");
  ASSERT_EQ(status_of(missing), 202) << missing;
  EXPECT_TRUE(
      has(events(session + "/operations/" + std::string(json::parse(text_of(missing)).at("id").as_string())), "event: failed\n"));
  EXPECT_EQ(status_of(ask("PUT", session + "/dataset", R"({"id":"nosuch"})")), 404);
}

TEST_F(RestOperations, EventsEndWithTheSession) {
  const std::string session = new_session("torus-200");
  ASSERT_EQ(status_of(ask("PUT", session + "/intervals", R"({"intervals":[{"lower":-1,"upper":2,"visible":false}]})")), 200);
  const std::string operation = session + "/operations/" + begin(session, R"({"format":"vtu","compression":9})");
  std::string told;
  std::thread listening([&] { told = events(operation); });
  while (!has(server_.ask("GET", "/metrics"),
              "isostrata_http_requests_total{method=\"GET\",route=\"/sessions/{session}/operations/"
              "{operation}/events\",status=\"200\"} 1"))
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_EQ(status_of(ask("DELETE", session)), 204);
  listening.join();
  EXPECT_TRUE(has(told, "event: failed\n") || has(told, "event: cancelled\n") || has(told, "event: done\n")) << told;
  EXPECT_TRUE(server_.answers());
}

TEST_F(RestOperations, AListenerWhoGoesAwayIsForgotten) {
  const std::string session = new_session("torus-12");
  const std::string operation = session + "/operations/" + begin(session, R"({"format":"vtu"})");
  for (int i = 0; i < 20; ++i) {
    RawSocket socket(server_.port());
    socket.send("GET /api/v1" + operation + "/events HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " +
                std::string(RunningServer::kToken) + "\r\n\r\n");
  }
  EXPECT_TRUE(has(events(operation), "event: done\n"));
}

}  // namespace
}  // namespace isostrata
