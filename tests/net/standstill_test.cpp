// Clients that stand still, flood, or leave and come back, each beside one that behaves: nobody else may notice.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "net/running_server.h"
#include "support/client_messages.h"

namespace isostrata {
namespace {

using client::Client;
using client::ClientError;
using std::chrono::milliseconds;

std::string ws_target() { return std::string("/ws?token=") + RunningServer::kToken; }

std::string hello(std::uint32_t width, std::uint32_t height, const std::string& resume_token = "") {
  v1::ClientMessage message;
  message.set_seq(1);
  message.mutable_hello()->set_protocol_major(1);
  message.mutable_hello()->set_resume_token(resume_token);
  message.mutable_hello()->mutable_viewport()->set_width(width);
  message.mutable_hello()->mutable_viewport()->set_height(height);
  return message.SerializeAsString();
}

/// Whether it becomes true within the time.
bool soon(const std::function<bool()>& what, milliseconds time = milliseconds(5000)) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (!what()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(milliseconds(5));
  }
  return true;
}

/// A client that reads what comes and acknowledges only when told to. Its frames are whole WebSocket messages of the server.
class SilentClient {
 public:
  explicit SilentClient(const RunningServer& server, const std::string& resume_token = "") : socket_(server.port()) {
    socket_.open_websocket(ws_target());
    socket_.send_frame(hello(64, 48, resume_token));
  }
  void send(v1::ClientMessage message) {
    message.set_seq(++seq_);
    socket_.send_frame(message.SerializeAsString());
  }
  void acknowledge(std::uint64_t frame) {
    v1::ClientMessage message;
    message.mutable_frame_ack()->set_frame_id(frame);
    send(std::move(message));
  }
  /// The next message; nothing after the time or at the end.
  std::optional<v1::ServerMessage> receive(int timeout_ms = 5000) {
    std::string payload;
    for (;;) {
      const auto piece = socket_.read_frame(timeout_ms);
      if (!piece) return std::nullopt;
      if (piece->opcode > 2) continue;
      payload += piece->payload;
      if (!piece->last) continue;
      v1::ServerMessage message;
      if (!message.ParseFromString(payload)) return std::nullopt;
      return message;
    }
  }
  std::optional<v1::ServerMessage> receive_until(const std::function<bool(const v1::ServerMessage&)>& wanted,
                                                 int timeout_ms = 5000) {
    while (auto message = receive(timeout_ms))
      if (wanted(*message)) return message;
    return std::nullopt;
  }
  RawSocket& socket() { return socket_; }

 private:
  RawSocket socket_;
  std::uint64_t seq_ = 1;
};

ServerOptions with_stall_time(milliseconds time) {
  ServerOptions options;
  options.stall_time = time;
  return options;
}

TEST(Standstill, WhoNeverAcknowledgesIsNotDrawnForUntilItDoes) {
  RunningServer server(with_stall_time(milliseconds(100)));
  SilentClient silent(server);
  const auto first = silent.receive_until([](const auto& m) { return m.has_frame(); });
  ASSERT_TRUE(first);
  std::uint64_t frame = first->frame().frame_id();
  // At most its credits come, and then nothing, however much changes.
  int frames = 1;
  while (const auto message = silent.receive(300))
    if (message->has_frame()) {
      frame = message->frame().frame_id();
      ++frames;
    }
  EXPECT_LE(frames, 2);
  const int drawn = server.control->drawn;
  std::uint64_t revision = 0;
  for (int i = 1; i <= 20; ++i) {
    silent.send(camera_at(i));
    const auto state = silent.receive_until([](const auto& m) { return m.has_state() || m.has_frame(); });
    ASSERT_TRUE(state);
    ASSERT_TRUE(state->has_state()) << "a frame for someone who does not acknowledge";
    revision = state->state().revision();
  }
  EXPECT_EQ(server.control->drawn, drawn);
  // Somebody else is drawn for meanwhile.
  Client other(server.client_options());
  other.open_dataset("torus-12");
  EXPECT_EQ(other.lossless_frame().width(), 64u);
  // The session is as it was, and goes on with its newest state at the first acknowledgement.
  silent.acknowledge(frame);
  const auto next = silent.receive_until([](const auto& m) { return m.has_frame(); });
  ASSERT_TRUE(next);
  EXPECT_EQ(next->frame().revision(), revision);
}

TEST(Standstill, WhoseSocketIsBlockedIsClosedWhileOthersGetFrames) {
  ServerOptions options;
  options.write_timeout = milliseconds(300);
  RunningServer server(std::move(options));
  server.control->noise = true;
  // A picture larger than any kernel buffers, for a client that never reads.
  RawSocket blocked(server.port(), 4096);
  blocked.open_websocket(ws_target());
  blocked.send_frame(hello(2048, 2048));
  ASSERT_TRUE(soon([&] { return server.control->drawn > 0; }));
  Client other(server.client_options());
  other.open_dataset("torus-12");
  const auto viewers = [&] { return server.health(); };
  int frames = 0;
  const bool closed = soon(
      [&] {
        EXPECT_EQ(other.lossless_frame().width(), 64u);
        ++frames;
        return has(viewers(), "\"viewers\":1");
      },
      milliseconds(15000));
  EXPECT_TRUE(closed) << viewers();
  EXPECT_GE(frames, 1);
  EXPECT_EQ(other.lossless_frame().width(), 64u);
}

TEST(Standstill, WhoFloodsAndNeverReadsIsCutOffAndOthersAreServed) {
  ServerOptions options;
  options.write_timeout = milliseconds(500);
  options.messages_per_second = 100'000;  // so that it is the answers that pile up, and not the messages
  RunningServer server(std::move(options));
  RawSocket rude(server.port(), 4096);
  ASSERT_EQ(status_of(rude.open_websocket(ws_target())), 101);
  ASSERT_TRUE(rude.send_frame(hello(64, 48)));
  Client polite(server.client_options());
  polite.open_dataset("torus-12");
  bool cut_off = false;
  std::uint64_t seq = 1;
  for (int round = 0; round < 400 && !cut_off; ++round) {
    std::string burst;
    for (int i = 0; i < 2000; ++i) {
      v1::ClientMessage message;
      message.set_seq(++seq);
      // Each is refused with a sentence that is longer than the message.
      message.mutable_set_view()->set_view("no such view at all");
      burst += std::string("\x82", 1) + static_cast<char>(0x80 | message.ByteSizeLong()) + std::string(4, '\0') +
               message.SerializeAsString();
    }
    cut_off = !rude.send(burst, 15000);
    if (round == 3) {
      EXPECT_EQ(polite.lossless_frame().width(), 64u);
    }
  }
  EXPECT_TRUE(cut_off) << "the server has kept " << seq << " answers for someone who does not read";
  polite.open_dataset("torus-12");
  EXPECT_EQ(polite.lossless_frame().width(), 64u);
}

TEST(Standstill, ASlowReaderIsNotABlockedOne) {
  ServerOptions options;
  options.write_timeout = milliseconds(400);
  options.stall_time = milliseconds(60000);
  RunningServer server(std::move(options));
  server.control->noise = true;
  RawSocket slow(server.port(), 65536);
  slow.open_websocket(ws_target());
  slow.send_frame(hello(2048, 2048));
  // The first frame takes longer than the write timeout as a whole, and never as long without any progress.
  // (It is the only one until it has been acknowledged, and it has to last for the whole time.)
  std::size_t read = 0;
  const auto began = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - began < milliseconds(1200)) {
    const std::size_t now = slow.read_at_most(20000);
    ASSERT_GT(now, 0u) << "closed after " << read << " bytes";
    read += now;
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_TRUE(slow.send_frame("x"));
  EXPECT_TRUE(has(server.health(), "\"viewers\":1"));
}

TEST(Standstill, WhoReadsAByteNowAndThenIsClosedWhileOthersGetFrames) {
  ServerOptions options;
  options.write_timeout = milliseconds(500);
  RunningServer server(std::move(options));
  server.control->noise = true;
  RawSocket dripping(server.port(), 4096);
  dripping.open_websocket(ws_target());
  dripping.send_frame(hello(2048, 2048));
  ASSERT_TRUE(soon([&] { return server.control->drawn > 0; }));
  Client other(server.client_options());
  other.open_dataset("torus-12");
  int frames = 0;
  const bool closed = soon(
      [&] {
        dripping.read_at_most(1, 1);
        EXPECT_EQ(other.lossless_frame().width(), 64u);
        ++frames;
        return has(server.health(), "\"viewers\":1");
      },
      milliseconds(20000));
  EXPECT_TRUE(closed);
  EXPECT_GE(frames, 2);
  EXPECT_EQ(other.lossless_frame().width(), 64u);
}

TEST(Standstill, WhoNeverSaysHelloIsClosed) {
  ServerOptions options;
  options.hello_timeout = milliseconds(100);
  RunningServer server(std::move(options));
  RawSocket socket(server.port());
  ASSERT_EQ(status_of(socket.open_websocket(ws_target())), 101);
  bool closed = false;
  socket.read_all(&closed, 5000);
  EXPECT_TRUE(closed);
}

RunningServer server_that_heeds(double messages_per_second) {
  ServerOptions options;
  options.messages_per_second = messages_per_second;
  return RunningServer(std::move(options));
}

TEST(Flood, OfTenThousandCamerasTheNewestWinsAndOthersAreServed) {
  RunningServer server = server_that_heeds(400);
  server.control->delay_ms = 5;
  Client flooding(server.client_options()), other(server.client_options());
  flooding.open_dataset("torus-12");
  other.open_dataset("torus-12");
  flooding.lossless_frame();
  other.lossless_frame();
  const int drawn = server.control->drawn;
  std::uint64_t last = 0;
  int others = 0, frames = 0;
  constexpr int kCameras = 10000;
  for (int i = 1; i <= kCameras; ++i) {
    last = flooding.send(camera_at(i));
    if (i % 2500) continue;
    other.command(camera_at(i));
    EXPECT_GE(other.lossless_frame().revision(), other.state().revision());
    ++others;
  }
  EXPECT_EQ(others, 4);
  v1::Frame newest;
  int reminders = 0;
  const auto began = std::chrono::steady_clock::now();
  while (newest.input_seq() < last && std::chrono::steady_clock::now() < began + std::chrono::seconds(30))
    if (const auto message = flooding.receive(milliseconds(200))) {
      if (message->has_error()) {
        EXPECT_EQ(message->error().code(), "too_many_messages");
        EXPECT_GT(message->error().in_reply_to(), 0u);
        ++reminders;
      }
      if (!message->has_frame()) continue;
      newest = message->frame();
      ++frames;
    }
  EXPECT_GE(reminders, 1) << "nobody has told the client that its cameras are passed over";
  EXPECT_GE(newest.input_seq(), last);
  EXPECT_EQ(flooding.state().camera().eye().x(), kCameras);
  EXPECT_EQ(newest.camera().eye().x(), kCameras);
  // Nothing queued up: far fewer pictures were drawn, and sent, than cameras came.
  EXPECT_LT(server.control->drawn - drawn, kCameras / 4);
  EXPECT_LT(frames, kCameras / 4);
}

TEST(Flood, OfMessagesThatAreNoCamerasIsReadLaterWholeAndInOrder) {
  RunningServer server = server_that_heeds(400);
  RawSocket socket(server.port());
  ASSERT_EQ(status_of(socket.open_websocket(ws_target())), 101);
  v1::ClientMessage first;
  first.set_seq(1);
  first.mutable_hello()->set_protocol_major(1);
  socket.send_frame(first.SerializeAsString());
  constexpr std::uint64_t kPings = 800;  // beyond what a connection may say at once
  std::thread writing([&] {
    for (std::uint64_t i = 1; i <= kPings; ++i) {
      v1::ClientMessage ping;
      ping.set_seq(1 + i);
      ping.mutable_ping()->set_client_time_ms(static_cast<double>(i));
      socket.send_frame(ping.SerializeAsString());
    }
  });
  std::uint64_t answered = 0;
  for (auto frame = socket.read_frame(); frame && frame->opcode != 8; frame = socket.read_frame()) {
    v1::ServerMessage answer;
    if (frame->opcode != 2 || !answer.ParseFromString(frame->payload) || !answer.has_pong()) continue;
    EXPECT_EQ(answer.pong().client_time_ms(), static_cast<double>(++answered));
    if (answered == kPings) break;
  }
  writing.join();
  EXPECT_EQ(answered, kPings);
}

TEST(Flood, TheLastCameraBeforeSilenceCounts) {
  RunningServer server = server_that_heeds(400);
  Client watching(server.client_options());
  watching.open_dataset("torus-12");
  constexpr int kCameras = 3000;
  auto options = server.client_options();
  options.resume_token = watching.welcome().resume_token();
  Client flooding(options);
  for (int i = 1; i <= kCameras; ++i) flooding.send(camera_at(i));
  EXPECT_TRUE(soon(
      [&] {
        watching.receive(milliseconds(50));
        return watching.state().camera().eye().x() == kCameras;
      },
      milliseconds(20000)))
      << watching.state().camera().eye().x();
}

TEST(Vanishing, AtAnyMomentAndWithoutGoodbyeLeavesNothingBehind) {
  RunningServer server;
  server.control->delay_ms = 20;
  Client other(server.client_options());
  other.open_dataset("torus-12");
  const std::string upgrade = "GET " + ws_target() +
                              " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                              "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                              "Sec-WebSocket-Protocol: isostrata.v1\r\n\r\n";
  const auto vanish = [&](const std::function<void(RawSocket&)>& after) {
    RawSocket socket(server.port());
    after(socket);
    socket.reset();
  };
  for (int round = 0; round < 6; ++round) {
    vanish([](RawSocket&) {});                                     // connected
    vanish([&](RawSocket& s) { s.send(upgrade.substr(0, 60)); });  // half a head
    vanish([&](RawSocket& s) { s.send(upgrade); });                // without reading the answer
    vanish([&](RawSocket& s) { s.open_websocket(ws_target()); });  // before Hello
    vanish([&](RawSocket& s) {                                     // half a message
      s.open_websocket(ws_target());
      s.send(std::string("\x82\xfe\x10\x00", 4) + std::string(100, 'x'));
    });
    vanish([&](RawSocket& s) {  // while its first picture is drawn
      s.open_websocket(ws_target());
      s.send_frame(hello(64, 48));
      s.read_frame();
    });
    vanish([&](RawSocket& s) {  // half a body
      s.send("POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\n{");
    });
    other.command(camera_at(round + 1));
    EXPECT_GE(other.lossless_frame().revision(), other.state().revision());
  }
  EXPECT_TRUE(
      soon([&] { return has(server.health(), "\"viewers\":1"); }));
}

TEST(TwoClients, OfOneSessionSeeEachOthersChangesAndEachGetsFrames) {
  RunningServer server;
  Client first(server.client_options());
  first.open_dataset("tets-6");
  auto options = server.client_options();
  options.resume_token = first.welcome().resume_token();
  options.width = 32;
  options.height = 24;
  Client second(options);
  ASSERT_EQ(second.welcome().session(), first.welcome().session());
  first.command(camera_at(3));
  second.command(camera_at(4));
  const auto seen = [](Client& client, double x) {
    for (int i = 0; i < 100; ++i) {
      if (client.state().camera().eye().x() == x) return true;
      client.receive(milliseconds(50));
    }
    return false;
  };
  EXPECT_TRUE(seen(first, 4));
  EXPECT_TRUE(seen(second, 4));
  EXPECT_EQ(first.state().revision(), second.state().revision());
  EXPECT_EQ(first.lossless_frame().width(), 64u);
  EXPECT_EQ(second.lossless_frame().width(), 32u);
  // One of them leaves; the other goes on.
  first.close();
  second.command(camera_at(5));
  EXPECT_EQ(second.lossless_frame().camera().eye().x(), 5);
}

TEST(TwoClients, WhoComesBackWhileTheOldSocketStillLivesIsServed) {
  RunningServer server(with_stall_time(milliseconds(100)));
  // As after a laptop's sleep: the server has not noticed that the old socket is dead.
  SilentClient old(server);
  const auto welcome = old.receive_until([](const auto& m) { return m.has_welcome(); });
  ASSERT_TRUE(welcome);
  ASSERT_TRUE(old.receive_until([](const auto& m) { return m.has_frame(); }));
  auto options = server.client_options();
  options.resume_token = welcome->welcome().resume_token();
  Client back(options);
  EXPECT_EQ(back.welcome().session(), welcome->welcome().session());
  back.command(camera_at(7));
  EXPECT_EQ(back.lossless_frame().camera().eye().x(), 7);
  // The old one wakes up after all and is still welcome.
  EXPECT_TRUE(old.receive_until([](const auto& m) { return m.has_state() && m.state().camera().eye().x() == 7; }));
}

TEST(WatchedSession, DeletedByAScriptTellsItsViewersAndEndsOnlyThem) {
  RunningServer server;
  Client watching(server.client_options()), other(server.client_options());
  watching.open_dataset("torus-12");
  other.open_dataset("tets-6");
  EXPECT_EQ(status_of(server.ask("DELETE", "/api/v1/sessions/" + watching.welcome().session())), 204);
  std::string reason, code;
  try {
    for (int i = 0; i < 100; ++i)
      if (const auto message = watching.receive(milliseconds(100)); message && message->has_shutdown())
        reason = message->shutdown().reason();
  } catch (const ClientError& error) {
    code = error.code();
  }
  EXPECT_EQ(reason, "the session was ended");
  EXPECT_EQ(code, "closed");
  EXPECT_EQ(status_of(server.ask("GET", "/api/v1/sessions/" + watching.welcome().session())), 404);
  EXPECT_EQ(other.lossless_frame().width(), 64u);
  // Its token is worth nothing any more: a fresh session begins.
  auto options = server.client_options();
  options.resume_token = watching.welcome().resume_token();
  Client again(options);
  EXPECT_NE(again.welcome().session(), watching.welcome().session());
  EXPECT_TRUE(again.state().dataset().empty());
}

TEST(WatchedSession, MayBeDeletedWhileItsPictureIsBeingDrawn) {
  RunningServer server;
  server.control->delay_ms = 100;
  for (int i = 0; i < 5; ++i) {
    Client watching(server.client_options());
    watching.open_dataset("torus-12");
    watching.send(camera_at(i));
    EXPECT_EQ(status_of(server.ask("DELETE", "/api/v1/sessions/" + watching.welcome().session())), 204);
  }
  EXPECT_TRUE(server.answers());
}

}  // namespace
}  // namespace isostrata
