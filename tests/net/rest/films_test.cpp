// Films over REST: each picture is what the session shows there.
#include <gtest/gtest.h>

#include <array>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <thread>

#include "isostrata/video.h"
#include "net/answers.h"
#include "net/http/json_body.h"
#include "net/running_server.h"
#include "session/films/film_plan.h"
#include "session/wire/wire.h"
#include "support/webm_elements.h"

namespace isostrata {
namespace {

namespace json = boost::json;

class RestFilms : public ::testing::Test {
 protected:
  static ServerOptions with_steps() {
    ServerOptions options;
    options.engine.catalogue = Catalogue::from_sources({"torus:12", "cylinder:24x24x8x6"});
    return options;
  }
  std::string ask(const std::string& method, const std::string& path, const std::string& body = "") {
    return server_.ask(method, "/api/v1" + path, body);
  }
  json::value get(const std::string& path) { return json::parse(text_of(ask("GET", path))); }
  std::string new_session(const std::string& dataset) {
    return "/sessions/" + std::string(json::parse(text_of(ask("POST", "/sessions", "{\"dataset\":\"" + dataset + "\"}"))).at("id").as_string());
  }
  std::string begin(const std::string& session, const std::string& body) {
    const auto response = ask("POST", session + "/films", body);
    EXPECT_EQ(status_of(response), 202) << response;
    return std::string(json::parse(text_of(response)).at("id").as_string());
  }
  std::string events(const std::string& session, const std::string& id) { return ask("GET", session + "/operations/" + id + "/events"); }
  /// Of one colour, as this renderer's are.
  std::array<int, 3> color(const client::Picture& picture) { return {picture.rgb.at(0), picture.rgb.at(1), picture.rgb.at(2)}; }
  std::vector<std::array<int, 3>> colors(std::string_view film) {
    const auto decoder = client::video_decoder("vp9-444");
    std::vector<std::array<int, 3>> all;
    for (const auto& frame : isostrata::testing::frames_of(film)) {
      const client::Picture picture = decoder->decode(std::string(frame.bytes));
      EXPECT_EQ(picture.width, 64);
      EXPECT_EQ(picture.height, 48);
      all.push_back(color(picture));
    }
    return all;
  }
  std::array<int, 3> shown(const std::string& session) { return color(client::decode(text_of(ask("GET", session + "/image?width=64&height=48")))); }
  static void expect_near(const std::array<int, 3>& a, const std::array<int, 3>& b, const std::string& of) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 4) << of;
  }

  /// Whether nothing is drawn for a fifth of a second, soon.
  bool rests() {
    for (int i = 0; i < 50; ++i) {
      const int drawn = server_.control->drawn;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      if (server_.control->drawn == drawn) return true;
    }
    return false;
  }

  RunningServer server_{with_steps()};
};

TEST_F(RestFilms, ATurnIsThePicturesOfItsCameras) {
  const std::string session = new_session("torus-12");
  ASSERT_EQ(status_of(ask("PUT", session + "/camera", R"({"eye":{"x":7,"y":1,"z":1},"at":{"x":0.5,"y":0.5,"z":0.5},"up":{"x":0,"y":0,"z":1},"fovDeg":30})")), 200);
  const std::string id = begin(session, R"({"turnDeg":-120,"seconds":1,"framesPerSecond":8,"width":64,"height":48,"samples":1})");
  EXPECT_TRUE(has(events(session, id), "event: done\ndata: {"));
  const auto result = get(session + "/operations/" + id).at("result");
  EXPECT_EQ(result.at("pictures").to_number<int>(), 8);
  EXPECT_EQ(result.at("seconds").to_number<double>(), 1);
  const std::string href = "/" + std::string(result.at("href").as_string());
  const auto file = ask("GET", href);
  ASSERT_EQ(status_of(file), 200) << file.substr(0, 300);
  EXPECT_TRUE(has(file, "Content-Type: video/webm"));
  EXPECT_TRUE(has(file, "attachment; filename=\"film-"));
  const std::string film = text_of(file);
  EXPECT_EQ(film.size(), result.at("bytes").to_number<std::size_t>());
  const auto frames = colors(film);
  ASSERT_EQ(frames.size(), 8u);
  const Camera from{{7, 1, 1}, {0.5, 0.5, 0.5}, {0, 0, 1}, 30, false};
  for (int i = 0; i < 8; ++i) {
    const auto put = ask("PUT", session + "/camera", message_json(to_wire(turned(from, -120.0 * i / 8))));
    ASSERT_EQ(status_of(put), 200) << put;
    expect_near(frames[static_cast<std::size_t>(i)], shown(session), "picture " + std::to_string(i));
  }
  EXPECT_EQ(status_of(ask("DELETE", href)), 204);
  EXPECT_EQ(status_of(ask("GET", href)), 404);
}

TEST_F(RestFilms, StepsAreThePicturesOfThoseSteps) {
  const std::string session = new_session("cylinder-24x24x8x6");
  const std::string id = begin(session, R"({"firstStep":5,"lastStep":1,"stepStride":2,"width":64,"height":48})");
  EXPECT_TRUE(has(events(session, id), "event: done\ndata: {"));
  const auto frames = colors(text_of(ask("GET", session + "/films/" + id)));
  ASSERT_EQ(frames.size(), 3u);
  for (const int step : {5, 3, 1}) {
    ASSERT_EQ(status_of(ask("PUT", session + "/time-step", "{\"step\":" + std::to_string(step) + "}")), 200);
    expect_near(frames[static_cast<std::size_t>((5 - step) / 2)], shown(session), "step " + std::to_string(step));
  }
}

TEST_F(RestFilms, TheSessionGoesOnWhileItsFilmIsMade) {
  const std::string session = new_session("torus-12");
  server_.control->delay_ms = 20;
  const std::string id = begin(session, R"({"turnDeg":360,"seconds":60,"framesPerSecond":60,"width":64,"height":48})");
  const auto revision = get(session + "/state").at("revision").as_string();
  ASSERT_EQ(status_of(ask("PUT", session + "/intervals", R"({"intervals":[]})")), 200);
  EXPECT_NE(get(session + "/state").at("revision").as_string(), revision);
  EXPECT_EQ(status_of(ask("GET", session + "/image?width=64&height=48")), 200);
  EXPECT_EQ(get(session + "/operations/" + id).at("status").as_string(), "running");
  const auto second = ask("POST", session + "/films", R"({"turnDeg":90})");
  EXPECT_EQ(status_of(second), 503) << second;
  EXPECT_TRUE(has(second, "is being made (" + id + ")")) << second;
  EXPECT_EQ(status_of(ask("GET", session + "/films/" + id)), 409);
  // It is cancelled by either name, at once, and is then forgotten.
  const auto cancelled = ask("DELETE", session + "/films/" + id);
  EXPECT_EQ(status_of(cancelled), 202) << cancelled;
  EXPECT_EQ(get(session + "/operations/" + id).at("status").as_string(), "cancelled");
  EXPECT_TRUE(has(events(session, id), "event: cancelled\n"));
  EXPECT_TRUE(rests()) << "it is still being drawn";
  EXPECT_EQ(status_of(ask("DELETE", session + "/operations/" + id)), 204);
}

TEST_F(RestFilms, ItEndsWithItsSession) {
  const std::string session = new_session("torus-12");
  server_.control->delay_ms = 20;
  const std::string id = begin(session, R"({"turnDeg":360,"seconds":60,"framesPerSecond":60,"width":64,"height":48})");
  EXPECT_EQ(status_of(ask("DELETE", session)), 204);
  EXPECT_TRUE(rests()) << "it is still being drawn";
}

TEST_F(RestFilms, ARendererThatFailsEndsItWithItsReason) {
  const std::string session = new_session("torus-12");
  server_.control->fail = true;
  const std::string id = begin(session, R"({"turnDeg":360})");
  EXPECT_TRUE(has(events(session, id), "event: failed\n"));
  EXPECT_NE(json::serialize(get(session + "/operations/" + id)).find("told to fail"), std::string::npos);
}

TEST_F(RestFilms, WhatIsNoFilmIsRefused) {
  const std::string session = new_session("torus-12");
  for (const std::string body : {R"({})", R"({"turnDeg":0})", R"({"turnDeg":1e9})", R"({"turnDeg":90,"width":100000})", R"({"firstStep":0,"lastStep":7})",
                                 R"({"turnDeg":90,"speed":2})", R"({"turnDeg":"left"})"}) {
    const auto response = ask("POST", session + "/films", body);
    EXPECT_EQ(status_of(response), 400) << body << response;
  }
  const auto empty = ask("POST", "/sessions", "{}");
  const std::string none = "/sessions/" + std::string(json::parse(text_of(empty)).at("id").as_string());
  EXPECT_EQ(status_of(ask("POST", none + "/films", R"({"turnDeg":90})")), 404);
  EXPECT_EQ(status_of(ask("GET", session + "/films/r1")), 404);
}

TEST_F(RestFilms, AnExportIsNoFilmAndASessionKeepsFourFiles) {
  const std::string session = new_session("torus-12");
  const auto exported = ask("POST", session + "/exports", R"({"format":"stl"})");
  const std::string id(json::parse(text_of(exported)).at("id").as_string());
  EXPECT_EQ(status_of(ask("GET", session + "/films/" + id)), 404);
  for (int i = 0; i < 3; ++i) events(session, begin(session, R"({"turnDeg":90,"seconds":0.1,"width":64,"height":48})"));
  EXPECT_EQ(status_of(ask("POST", session + "/films", R"({"turnDeg":90})")), 503);
  EXPECT_EQ(status_of(ask("POST", session + "/exports", R"({"format":"stl"})")), 503);
}

}  // namespace
}  // namespace isostrata
