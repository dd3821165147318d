// Whoever has gone waits for nothing: what was asked is given up.
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <memory>
#include <string>
#include <vector>

#include "net/running_server.h"

namespace isostrata {
namespace {

std::string new_session(const RunningServer& server) {
  const std::string made = server.ask("POST", "/api/v1/sessions", R"({"dataset":"torus-12"})");
  return std::string(boost::json::parse(made.substr(made.find("\r\n\r\n") + 4)).at("id").as_string());
}

std::string image_request(const std::string& session, int width, const std::string& headers = "") {
  return "GET /api/v1/sessions/" + session + "/image?height=16&width=" + std::to_string(width) +
         " HTTP/1.1\r\nHost: localhost\r\n" + headers + "Authorization: Bearer " + RunningServer::kToken + "\r\n\r\n";
}

TEST(GoneClient, PicturesThatNobodyWaitsForAreNotDrawn) {
  RunningServer server;
  const std::string session = new_session(server);
  server.ask("GET", "/api/v1/sessions/" + session + "/image?width=16&height=16");
  server.control->drawn = 0;
  server.control->delay_ms = 400;
  constexpr int kAsked = 20;
  {
    std::vector<std::unique_ptr<RawSocket>> sockets;
    for (int i = 0; i < kAsked; ++i) {
      sockets.push_back(std::make_unique<RawSocket>(server.port()));
      sockets.back()->send(image_request(session, 20 + i));
    }
  }
  const std::string answer = server.ask("GET", "/api/v1/sessions/" + session + "/image?width=16&height=16");
  EXPECT_EQ(status_of(answer), 200);
  EXPECT_LT(server.control->drawn, kAsked / 2) << "pictures that nobody waits for were drawn first";
}

TEST(GoneClient, WhatAConnectionSendsAheadDoesNotLookLikeItsEnd) {
  RunningServer server;
  const std::string session = new_session(server);
  server.control->delay_ms = 100;
  RawSocket socket(server.port());
  socket.send(image_request(session, 16) + image_request(session, 17, "Connection: close\r\n"));
  const std::string answers = socket.read_all();
  const auto second = answers.rfind("HTTP/1.1 ");
  EXPECT_GT(second, 0u);
  EXPECT_EQ(status_of(answers), 200);
  EXPECT_EQ(status_of(answers.substr(second)), 200);
}

}  // namespace
}  // namespace isostrata
