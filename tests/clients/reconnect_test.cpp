// The C++ client when its connection is lost: to a real server that is killed and started again, cut in the middle, or gone.
#include <gtest/gtest.h>

#include <thread>

#include "clients/code_of.h"
#include "isostrata/client.h"
#include "support/cutting_proxy.h"
#include "support/kept.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

using namespace std::chrono_literals;
using client::Client;
using client::ConnectionEvent;

class Reconnect : public ::testing::Test {
 protected:
  client::Options options(int width = 64) {
    client::Options out{.url = server_.url(), .width = width, .height = 48};
    out.on_connection = [this](const ConnectionEvent& event) { events_.push_back(event); };
    return out;
  }
  std::size_t restored() const {
    std::size_t count = 0;
    for (const ConnectionEvent& event : events_) count += event.kind == ConnectionEvent::Kind::restored;
    return count;
  }

  std::vector<std::string> arguments() {
    folder_.write("token", "the-same-token-in-every-life\n");
    return {"torus:12", "--token-file", (folder_ / "token").string(), "--state-dir", (folder_ / "state").string()};
  }

  TemporaryFolder folder_;
  Served server_{arguments()};
  std::vector<ConnectionEvent> events_;
};

TEST_F(Reconnect, AClientGoesOnWhileTheServerIsKilledAndStartedAgain) {
  SERVED_OR_SKIP(server_);
  Client client(options());
  client.open_dataset("torus:12");
  client.set_intervals({client::interval(0.1, 0.2), client::interval(0.3, 0.4, {.name = "the-second"})});
  const std::string session = client.welcome().session();
  const auto id = client.state().intervals(0).id();
  std::thread killer([&] {
    wait_until_kept(folder_ / "state", "the-second");
    server_.restart();
  });
  // Every call returns when it is done, whichever server did it.
  int moves = 0;
  for (int after = 0; after < 20 && moves < 100000; ++moves) {
    const double lower = 0.05 + 0.0001 * (moves % 100);
    client.move_interval(id, lower, 0.25);
    ASSERT_EQ(client.interval_of(id).lower(), lower) << "move " << moves;
    after += restored() > 0;
  }
  killer.join();
  ASSERT_EQ(restored(), 1u);
  EXPECT_EQ(events_.front().kind, ConnectionEvent::Kind::lost);
  EXPECT_FALSE(events_.back().new_session);
  EXPECT_EQ(client.welcome().session(), session);
  EXPECT_EQ(client.state().intervals(1).upper(), 0.4);
  EXPECT_EQ(client.dataset().id(), "torus-12");
  const v1::Frame frame = client.lossless_frame();
  EXPECT_EQ(frame.revision(), client.state().revision());
  EXPECT_EQ(frame.payload(), client.still(64, 48));
}

TEST_F(Reconnect, WhatTheServerDidNotHearIsSentAgainInItsOrder) {
  SERVED_OR_SKIP(server_);
  Client client(options());
  client.open_dataset("torus:12");
  const auto id = client.state().intervals(0).id();
  wait_until_kept(folder_ / "state", "torus-12");
  server_.stop(SIGKILL);
  std::uint64_t last = 0;
  for (int i = 1; i <= 30; ++i) {
    v1::ClientMessage message;
    message.mutable_patch_interval()->set_id(id);
    message.mutable_patch_interval()->set_upper(0.5 + 0.001 * i);
    last = client.send(std::move(message));
  }
  std::thread again([&] { server_.restart(); });
  v1::Frame frame;
  while (frame.input_seq() < last) {
    const auto next = client.next_frame(30s);
    ASSERT_TRUE(next) << "no frame with the last input";
    frame = *next;
  }
  again.join();
  EXPECT_EQ(frame.input_seq(), last);
  EXPECT_EQ(client.interval_of(id).upper(), 0.53);
  ASSERT_EQ(restored(), 1u);
  EXPECT_GE(events_.back().resent, 30u);
}

TEST_F(Reconnect, ACutConnectionToALivingServerLosesNothingAndDoesNothingTwice) {
  SERVED_OR_SKIP(server_);
  CuttingProxy proxy(server_.url());
  client::Options through = options(0);
  through.url = proxy.url();
  Client client(through);
  client.open_dataset("torus:12");
  client.set_intervals({});
  for (int i = 0; i < 12; ++i) {
    proxy.cut();
    const auto before = client.state().intervals_size();
    client.add_interval(client::interval(0.01 * i, 0.01 * i + 0.5));
    ASSERT_EQ(client.state().intervals_size(), before + 1);
    proxy.cut();
    EXPECT_EQ(code_of([&] { client.move_interval(4711, 0, 1); }), "not_found")
        << "a refusal is heard, however often the way is lost";
    EXPECT_EQ(client.histogram(client.state().array(), 8).counts_size(), 8);
  }
  EXPECT_EQ(client.state().intervals_size(), 12);
  EXPECT_GE(restored(), 12u);
}

TEST_F(Reconnect, AnAnswerThatIsLostOnItsWayIsHeardLater) {
  SERVED_OR_SKIP(server_);
  CuttingProxy proxy(server_.url());
  client::Options through = options(0);
  through.url = proxy.url();
  Client client(through);
  client.open_dataset("torus:12");
  const auto revision = client.state().revision();
  proxy.swallow_answers();  // the server hears everything; then the connection ends
  std::thread cutter([&] {
    std::this_thread::sleep_for(200ms);
    proxy.cut();
  });
  EXPECT_EQ(code_of([&] { client.move_interval(4711, 0, 1); }), "not_found");
  cutter.join();
  proxy.swallow_answers();
  std::thread second([&] {
    std::this_thread::sleep_for(200ms);
    proxy.cut();
  });
  client.add_interval(client::interval(0.1, 0.7));
  second.join();
  EXPECT_EQ(client.state().revision(), revision + 1) << "done once";
  EXPECT_EQ(restored(), 2u);
}

TEST_F(Reconnect, AServerWithoutMemoryIsToldWhatWasShown) {
  SERVED_OR_SKIP(server_);
  Client client(options());
  client.open_dataset("torus:12");
  client.set_intervals({client::interval(0.1, 0.2, {.color = "#ff8000", .name = "kept"})});
  client::Options joining = options(0);
  joining.session = client.welcome().session();
  Client joined(joining);
  const std::string picture = client.still(64, 48);
  server_.stop(SIGKILL);
  std::filesystem::remove_all(folder_ / "state");
  server_.restart();
  client.set_annotations(false, false, false);
  ASSERT_EQ(client.state().intervals_size(), 1);
  EXPECT_EQ(client.state().intervals(0).name(), "kept");
  EXPECT_EQ(client.still(64, 48), picture);
  EXPECT_TRUE(events_.back().new_session);
  EXPECT_NE(client.welcome().session(), joining.session);
  EXPECT_EQ(code_of([&] { joined.set_view("+x"); }), "session_lost");
  EXPECT_EQ(code_of([&] { joined.set_view("+x"); }), "session_lost") << "and it stays so";
}

TEST_F(Reconnect, NobodyThereIsAnErrorAfterTheTimeThatWasGiven) {
  SERVED_OR_SKIP(server_);
  client::Options patient = options(0), impatient = options(0);
  patient.reconnect_for = 300ms;
  impatient.reconnect_for = 0ms;
  Client first(patient), second(impatient);
  server_.stop(SIGKILL);
  EXPECT_EQ(code_of([&] { second.set_view("+x"); }), "closed");
  EXPECT_TRUE(events_.empty());
  EXPECT_EQ(code_of([&] { first.set_view("+x"); }), "closed");
  ASSERT_EQ(events_.size(), 2u);
  EXPECT_EQ(events_.back().kind, ConnectionEvent::Kind::given_up);
  EXPECT_NE(events_.back().reason.find("could not be made again"), std::string::npos) << events_.back().reason;
  EXPECT_EQ(code_of([&] { first.set_view("+x"); }), "closed");
}

TEST_F(Reconnect, WhatEndsForGoodIsNotAskedAgain) {
  SERVED_OR_SKIP(server_);
  client::Options forever = options(0);
  forever.reconnect_for = std::chrono::hours(1);
  Client client(forever);
  client::http_request(forever, "DELETE", "api/v1/sessions/" + client.welcome().session());
  EXPECT_EQ(code_of([&] { client.set_view("+x"); }), "closed");
  Client other(forever);
  folder_.write("token", "another-token-than-before\n");
  server_.restart();
  EXPECT_EQ(code_of([&] { other.set_view("+x"); }), "unauthorized");
}

TEST_F(Reconnect, AStopIsHeardWhileNobodyIsThere) {
  SERVED_OR_SKIP(server_);
  std::atomic<bool> stop = false;
  client::Options forever = options(0);
  forever.reconnect_for = std::chrono::hours(1);
  forever.stop = &stop;
  Client client(forever);
  client.open_dataset("torus:12");
  wait_until_kept(folder_ / "state", "torus-12");
  server_.stop(SIGKILL);
  std::thread stopping([&] {
    std::this_thread::sleep_for(200ms);
    stop = true;
  });
  EXPECT_EQ(code_of([&] { client.set_view("+x"); }), "cancelled");
  stopping.join();
  EXPECT_EQ(code_of([&] { client.set_view("+x"); }), "cancelled");
  stop = false;
  server_.restart();
  client.set_annotations(true, false, false);
  EXPECT_EQ(restored(), 1u) << "it can go on afterwards";
}

}  // namespace
}  // namespace isostrata::testing
