#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "net/running_server.h"

namespace isostrata {
namespace {

using client::Client;
using client::ClientError;

std::string ws_target() { return std::string("/ws?token=") + RunningServer::kToken; }

std::string hello(std::uint64_t seq, std::uint32_t major = 1) {
  v1::ClientMessage message;
  message.set_seq(seq);
  message.mutable_hello()->set_protocol_major(major);
  return message.SerializeAsString();
}

class WebSocket : public ::testing::Test {
 protected:
  void expect_still_serving() {
    Client client(server_.client_options());
    client.open_dataset("torus-12");
    EXPECT_EQ(client.lossless_frame().width(), 64u);
  }
  RunningServer server_;
};

TEST_F(WebSocket, AFirstVisitSeesTheFirstDatasetMovingThenLossless) {
  Client client(server_.client_options());
  std::vector<v1::FramePhase> phases;
  for (int i = 0; i < 100 && (phases.empty() || phases.back() != v1::FRAME_PHASE_LOSSLESS); ++i)
    if (const auto message = client.receive(std::chrono::milliseconds(200)); message && message->has_frame())
      phases.push_back(message->frame().phase());
  ASSERT_GE(phases.size(), 2u);
  EXPECT_EQ(phases.front(), v1::FRAME_PHASE_MOVING);
  EXPECT_EQ(phases.back(), v1::FRAME_PHASE_LOSSLESS);
  EXPECT_EQ(client.dataset().id(), "torus-12");
}

TEST_F(WebSocket, AFrameNamesTheInputAndTheRevisionThatItContains) {
  Client client(server_.client_options());
  client.open_dataset("torus-12");
  v1::ClientMessage move;
  move.mutable_patch_interval()->set_id(client.state().intervals(0).id());
  move.mutable_patch_interval()->set_lower(0.21);
  const auto seq = client.send(std::move(move));
  for (int i = 0; i < 100; ++i) {
    const auto message = client.receive(std::chrono::milliseconds(200));
    if (!message || !message->has_frame() || message->frame().input_seq() < seq) continue;
    EXPECT_EQ(message->frame().revision(), client.state().revision());
    EXPECT_EQ(client.state().intervals(0).lower(), 0.21);
    EXPECT_GT(message->frame().stages().total_ms(), 0);
    return;
  }
  FAIL() << "no frame contains the input";
}

TEST_F(WebSocket, LayerFactsFollowTheLosslessFrame) {
  Client client(server_.client_options());
  client.open_dataset("torus-12");
  const v1::Frame frame = client.lossless_frame();
  v1::LayerFacts told;
  for (int i = 0; i < 100 && told.intervals().empty(); ++i)
    if (const auto message = client.receive(std::chrono::seconds(10)); message && message->has_layer_facts())
      told = message->layer_facts();
  ASSERT_EQ(told.intervals_size(), frame.facts().intervals_size());
  ASSERT_GT(told.intervals_size(), 0);
  for (int i = 0; i < told.intervals_size(); ++i) {
    EXPECT_EQ(told.intervals(i).id(), frame.facts().intervals(i).id());
    EXPECT_EQ(told.intervals(i).volume(), frame.facts().intervals(i).volume());
    EXPECT_FALSE(frame.facts().intervals(i).has_volume_error());
    EXPECT_TRUE(told.intervals(i).has_volume_error());
    EXPECT_GT(told.intervals(i).volume_error(), 0);
  }
  // What is asked for is the same, and a camera does not change it.
  client.set_view("+x");
  EXPECT_EQ(client.layer_facts().intervals(0).SerializeAsString(), told.intervals(0).SerializeAsString());
}

TEST_F(WebSocket, APlaceIsProbedAsTheNewestCameraSeesIt) {
  Client client(server_.client_options());
  client.open_dataset("torus-12");
  client.set_intervals({client::interval(0.1, 0.3)});
  client.set_camera([] {
    v1::Camera camera;
    camera.mutable_eye()->set_z(4);
    camera.mutable_at();
    camera.mutable_up()->set_y(1);
    camera.set_fov_deg(30);
    return camera;
  }());
  const auto probe = [&](double x, double y) {
    v1::ClientMessage ask;
    ask.mutable_probe_point()->set_x(x);
    ask.mutable_probe_point()->set_y(y);
    const auto seq = client.send(std::move(ask));
    for (int i = 0; i < 200; ++i) {
      const auto message = client.receive(std::chrono::seconds(1));
      if (message && message->has_probe_result() && message->probe_result().in_reply_to() == seq) return *message;
      if (message && message->has_error() && message->error().in_reply_to() == seq) return *message;
    }
    ADD_FAILURE() << "no answer";
    return v1::ServerMessage();
  };
  const v1::ProbeResult middle = probe(0.5, 0.5).probe_result();
  EXPECT_FALSE(middle.hit()) << "the hole of the torus";
  EXPECT_EQ(middle.revision(), client.state().revision());
  const double there = 0.5 + 0.6 / (4 * std::tan(15 * std::numbers::pi / 180)) / 2;  // in the middle of the tube, upwards
  const v1::ProbeResult tube = probe(0.5, 1 - there).probe_result();
  ASSERT_TRUE(tube.hit()) << tube.miss();
  EXPECT_EQ(tube.interval(), client.state().intervals(0).id());
  EXPECT_NEAR(tube.position().y(), 0.6, 0.06);
  EXPECT_NEAR(tube.arrays(0).value(), 0.3, 1e-6) << "the outer side of the ring";
  EXPECT_EQ(tube.end(), v1::PROBE_END_UPPER);
  EXPECT_EQ(client.probe(0.5, 1 - there, 64, 48).position().SerializeAsString(), tube.position().SerializeAsString()) << "REST says the same";
  EXPECT_EQ(probe(0.5, -1).error().field(), "y");
}

TEST_F(WebSocket, ALineIsAskedForByMessageAndByClientAlike) {
  Client client(server_.client_options());
  client.open_dataset("torus-12");
  client.set_intervals({client::interval(0.1, 0.3)});
  v1::ClientMessage ask;
  ask.mutable_probe_line()->mutable_from()->set_x(-1);
  ask.mutable_probe_line()->mutable_to()->set_x(1);
  const auto seq = client.send(std::move(ask));
  v1::ProbedCurve told;
  for (int i = 0; i < 200 && told.in_reply_to() != seq; ++i)
    if (const auto message = client.receive(std::chrono::seconds(1)); message && message->has_probed_curve()) told = message->probed_curve();
  ASSERT_EQ(told.in_reply_to(), seq);
  EXPECT_EQ(told.array(), "distance");
  EXPECT_EQ(told.layers(0).interval(), client.state().intervals(0).id());
  v1::ProbedCurve same = client.probe_line({-1, 0, 0}, {1, 0, 0}, "distance");
  same.set_in_reply_to(seq);
  EXPECT_EQ(same.SerializeAsString(), told.SerializeAsString());
}

TEST_F(WebSocket, ALayersStatisticsAreAskedForByMessageAndByClientAlike) {
  Client client(server_.client_options());
  client.open_dataset("torus-12");
  client.set_intervals({client::interval(0.1, 0.3)});
  const std::uint32_t id = client.state().intervals(0).id();
  const auto told = [&](std::uint32_t interval) {
    v1::ClientMessage ask;
    ask.mutable_request_layer_statistics()->set_interval(interval);
    const auto seq = client.send(std::move(ask));
    for (int i = 0; i < 200; ++i) {
      const auto message = client.receive(std::chrono::seconds(1));
      if (message && message->has_layer_statistics() && message->layer_statistics().in_reply_to() == seq) return *message;
      if (message && message->has_error() && message->error().in_reply_to() == seq) return *message;
    }
    ADD_FAILURE() << "no answer";
    return v1::ServerMessage();
  };
  v1::LayerStatistics found = told(id).layer_statistics();
  EXPECT_EQ(found.revision(), client.state().revision());
  EXPECT_EQ(found.array(), "distance");
  found.clear_in_reply_to();
  EXPECT_EQ(client.layer_statistics(id).SerializeAsString(), found.SerializeAsString());
  EXPECT_EQ(told(id + 1).error().field(), "interval");
}

TEST_F(WebSocket, CommandsSentWhileADatasetOpensTakeEffectOnIt) {
  Client client(server_.client_options());
  v1::ClientMessage open, set;
  open.mutable_open_dataset()->set_id("tets-6");
  auto* interval = set.mutable_set_intervals()->add_intervals();
  interval->set_lower(0.2);
  interval->set_upper(0.9);
  interval->set_visible(true);
  client.send(std::move(open));
  client.send(std::move(set));
  for (int i = 0; i < 100 && !(client.state().dataset() == "tets-6" && client.state().intervals_size() == 1); ++i)
    client.receive(std::chrono::milliseconds(100));
  EXPECT_EQ(client.state().dataset(), "tets-6");
  EXPECT_EQ(client.state().intervals_size(), 1);
}

TEST_F(WebSocket, ASessionOutlivesItsSocket) {
  auto options = server_.client_options();
  std::string session;
  {
    Client first(options);
    first.open_dataset("tets-6");
    options.resume_token = first.welcome().resume_token();
    session = first.welcome().session();
  }
  Client second(options);
  EXPECT_EQ(second.welcome().session(), session);
  EXPECT_EQ(second.state().dataset(), "tets-6");
  EXPECT_EQ(second.dataset().id(), "tets-6");
}

TEST_F(WebSocket, AnUnknownResumeTokenGetsAFreshAndEmptySession) {
  auto options = server_.client_options();
  options.resume_token = std::string(48, 'f');
  Client client(options);
  EXPECT_NE(client.welcome().resume_token(), options.resume_token);
  EXPECT_TRUE(client.state().dataset().empty());
}

TEST_F(WebSocket, TheDoorIsAsNarrowAsThePages) {
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket(ws_target())), 101);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket("/ws")), 401);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket("/ws?token=x")), 401);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket("/elsewhere?token=x")), 404);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket(ws_target(), "", "evil.example")), 403);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket(ws_target(), "Origin: http://evil.example\r\n")), 403);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket(ws_target(), "Origin: http://localhost\r\n")), 101);
  EXPECT_EQ(status_of(RawSocket(server_.port()).open_websocket(ws_target(), "", "localhost", "isostrata.v2")), 400);
}

struct BadMessage {
  const char* what;
  std::string bytes;
  int opcode;
  const char* code;
};

class BadMessages : public WebSocket, public ::testing::WithParamInterface<BadMessage> {};

TEST_P(BadMessages, GetATypedErrorAndTheEnd) {
  RawSocket socket(server_.port());
  ASSERT_EQ(status_of(socket.open_websocket(ws_target())), 101);
  socket.send_frame(GetParam().bytes, GetParam().opcode);
  bool closed = false;
  std::string answer;
  // The close is answered, as a client must, so that the server need not wait for it.
  socket.send_frame(std::string("\x03\xe8", 2), 8);
  answer = socket.read_all(&closed);
  EXPECT_TRUE(closed) << GetParam().what;
  EXPECT_TRUE(has(answer, GetParam().code)) << GetParam().what;
  expect_still_serving();
}

INSTANTIATE_TEST_SUITE_P(Table, BadMessages,
                         ::testing::Values(BadMessage{"garbage", std::string("\xff\xff\xff\xff\x00garbage", 12), 2, "malformed"},
                                           BadMessage{"text", "hello", 1, "malformed"},
                                           BadMessage{"another version", hello(1, 2), 2, "unsupported_version"},
                                           BadMessage{"seq zero", hello(0), 2, "malformed"},
                                           BadMessage{"not hello", std::string("\x08\x01\x9a\x01\x00", 5), 2, "malformed"},
                                           BadMessage{"too large", std::string((1 << 20) + 1, 'x'), 2, ""},
                                           BadMessage{"a reserved opcode", "x", 5, ""},
                                           BadMessage{"nothing", "", 2, "malformed"}),
                         [](const auto& info) {
                           std::string name = info.param.what;
                           for (char& c : name)
                             if (c == ' ') c = '_';
                           return name;
                         });

TEST_F(WebSocket, VanishingClientsLeaveNothingBehind) {
  for (int i = 0; i < 20; ++i) {
    RawSocket socket(server_.port());
    socket.open_websocket(ws_target());
    socket.send_frame(hello(1));
  }
  expect_still_serving();
  std::string health;
  for (int i = 0; i < 100 && !has(health, "\"viewers\":0"); ++i) {
    health = server_.health();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(has(health, "\"viewers\":0")) << health;
}

TEST_F(WebSocket, ARendererThatFailsIsAnErrorAndNotTheEnd) {
  Client client(server_.client_options());
  client.open_dataset("torus-12");
  server_.control->fail = true;
  EXPECT_THROW(client.lossless_frame(), ClientError);
  server_.control->fail = false;
  v1::ClientMessage view;
  view.mutable_set_view()->set_view("+x");
  client.command(std::move(view));
  EXPECT_GE(client.lossless_frame().revision(), client.state().revision());
}

TEST_F(WebSocket, RefusedCommandsNameTheMessage) {
  Client client(server_.client_options());
  client.open_dataset("torus-12");
  for (const std::string id : {"nosuch", ""}) {
    v1::ClientMessage message;
    message.mutable_open_dataset()->set_id(id);
    const auto seq = client.send(std::move(message));
    bool refused = false;
    for (int i = 0; i < 50 && !refused; ++i)
      if (const auto answer = client.receive(std::chrono::milliseconds(200)); answer && answer->has_error())
        refused = answer->error().in_reply_to() == seq;
    EXPECT_TRUE(refused) << id;
  }
  EXPECT_EQ(client.state().dataset(), "torus-12");
}

TEST(WebSocketLimits, ASessionIsRefusedOnlyWhereAllAreWatched) {
  ServerOptions options;
  options.max_sessions = 2;
  RunningServer server(std::move(options));
  Client first(server.client_options());
  {
    Client second(server.client_options());
    try {
      Client third(server.client_options());
      FAIL() << "three sessions where two are allowed";
    } catch (const ClientError& error) {
      EXPECT_EQ(error.code(), "unavailable");
    }
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  Client third(server.client_options());
  EXPECT_FALSE(third.welcome().session().empty());
}

TEST(WebSocketShutdown, ClientsAreToldWhy) {
  RunningServer server;
  Client client(server.client_options());
  std::thread ending([&] { server.end(); });
  std::string reason;
  try {
    for (int i = 0; i < 100; ++i)
      if (const auto message = client.receive(std::chrono::milliseconds(100)); message && message->has_shutdown())
        reason = message->shutdown().reason();
  } catch (const ClientError& error) {
    EXPECT_EQ(error.code(), "closed");
  }
  ending.join();
  EXPECT_EQ(reason, "the test ends");
}

}  // namespace
}  // namespace isostrata
