// A server whose engine is a process of its own, seen by its clients while that process dies.
#include <gtest/gtest.h>

#include <csignal>

#include "net/running_server.h"
#include "support/places.h"

namespace isostrata {
namespace {

using client::Client;
using namespace std::chrono_literals;

ServerOptions options_with_worker() {
  ServerOptions options;
  options.worker.emplace();
  options.worker->plan.program = isostrata::places::binaries() + "/isostrata-faulty-worker";
  options.worker->plan.arguments.clear();
  return options;
}

class ServerWithWorker : public ::testing::Test {
 protected:
  explicit ServerWithWorker(ServerOptions options = options_with_worker()) : server_(std::move(options)) {}

  pid_t worker() {
    for (int i = 0; i < 6000; ++i) {
      if (const pid_t process = server_.engine().facts().process) return process;
      std::this_thread::sleep_for(10ms);
    }
    ADD_FAILURE() << "no worker comes";
    return 0;
  }
  /// Never to process 0, which would be this one and all around it.
  void signal_worker(int signal) {
    if (const pid_t process = worker(); process > 0) kill(process, signal);
  }
  /// Moves an end of the first interval; the input's number.
  static std::uint64_t drag(Client& client, double lower) {
    v1::ClientMessage move;
    move.mutable_patch_interval()->set_id(client.state().intervals(0).id());
    move.mutable_patch_interval()->set_lower(lower);
    return client.send(std::move(move));
  }
  /// Reads on until a frame contains the input; what came meanwhile is looked at.
  template <class Look>
  static bool frame_with(Client& client, std::uint64_t seq, const Look& look) {
    const auto until = std::chrono::steady_clock::now() + 60s;
    while (std::chrono::steady_clock::now() < until) {
      const auto message = client.receive(200ms);
      if (!message) continue;
      look(*message);
      if (message->has_frame() && message->frame().input_seq() >= seq) return true;
    }
    return false;
  }

  RunningServer server_;
};

TEST_F(ServerWithWorker, ADragGoesOnOverAKilledWorkerOnTheSameConnection) {
  Client client(server_.client_options());
  Client other(server_.client_options());
  client.open_dataset("torus-12");
  other.open_dataset("tets-6");
  const std::string before = other.lossless_frame().payload();
  std::uint64_t revision = 0, frame_id = 0;
  int errors = 0, said = 0;
  const auto look = [&](const v1::ServerMessage& message) {
    errors += message.has_error();
    said += message.has_progress() && message.progress().stage().find("signal 9") != std::string::npos;
    if (!message.has_frame()) return;
    EXPECT_GT(message.frame().frame_id(), frame_id);
    EXPECT_GE(message.frame().revision(), revision) << "a stale frame";
    frame_id = message.frame().frame_id();
    revision = message.frame().revision();
  };
  double lower = 0.1;
  for (int i = 0; i < 40; ++i) {
    const std::uint64_t seq = drag(client, lower += 0.002);
    if (i == 10 || i == 25) signal_worker(SIGKILL);
    if (i % 5 != 4) continue;
    ASSERT_TRUE(frame_with(client, seq, look)) << "no frame contains move " << i;
  }
  const std::uint64_t shown = client.lossless_frame().revision();
  EXPECT_EQ(shown, client.state().revision());
  EXPECT_EQ(client.state().intervals(0).lower(), lower);
  EXPECT_EQ(errors, 0);
  EXPECT_GE(said, 1) << "viewers are told";
  v1::ClientMessage still;
  still.mutable_request_still();
  other.send(std::move(still));
  EXPECT_EQ(other.lossless_frame().payload(), before) << "the other session's picture, from another process";
  EXPECT_EQ(server_.engine().facts().deaths, 2u);
  EXPECT_TRUE(server_.engine().facts().fallback.empty());
}

TEST_F(ServerWithWorker, TheApiSaysWhoDrawsAndWhoDied) {
  std::string said = server_.ask("GET", "/api/v1/engine");
  EXPECT_TRUE(has(said, "\"process\":" + std::to_string(worker()))) << said;
  EXPECT_TRUE(has(said, "\"deaths\":0")) << said;
  for (int i = 0; i < 3; ++i) {
    signal_worker(SIGKILL);
    for (int n = 0; n < 6000 && server_.engine().facts().deaths == static_cast<std::uint64_t>(i); ++n)
      std::this_thread::sleep_for(10ms);
  }
  worker();
  said = server_.ask("GET", "/api/v1/engine");
  EXPECT_TRUE(has(said, "\"deaths\":3")) << said;
  EXPECT_TRUE(has(said, "signal 9")) << said;
  EXPECT_TRUE(has(said, "3 times in 60 s")) << said;
  EXPECT_TRUE(has(server_.ask("GET", "/metrics"), "isostrata_worker_deaths 3"));
  Client client(server_.client_options());
  EXPECT_TRUE(has(client.welcome().device(), "in place of plain")) << client.welcome().device();
  client.open_dataset("torus-12");
  EXPECT_TRUE(has(client.lossless_frame().facts().device(), "in place of plain"));
}

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

TEST_F(ServerWithWorker, AFloodToAWorkerThatStandsStillFillsNoMemory) {
  Client client(server_.client_options());
  client.open_dataset("torus-12");
  client.lossless_frame();
  signal_worker(SIGSTOP);
  const std::size_t before = resident_bytes();
  v1::ClientMessage flood;
  auto& intervals = *flood.mutable_set_intervals();
  for (int i = 0; i < 256; ++i) {
    auto* interval = intervals.add_intervals();
    interval->set_lower(0.001 * i);
    interval->set_upper(0.001 * (i + 1));
    interval->set_opacity(0.5);
    interval->set_visible(true);
    interval->set_name(std::string(200, 'n'));
  }
  // Scenes of some 100 KB each, 300 of which would be 30 MB on their way.
  for (int i = 0; i < 300; ++i) {
    intervals.mutable_intervals(0)->set_lower(-0.001 * i);
    client.send(flood);
    while (client.receive(0ms)) {
    }
  }
#ifndef ISOSTRATA_SANITIZED  // it keeps what was freed
  EXPECT_LT(resident_bytes(), before + (20u << 20));
#endif
  signal_worker(SIGCONT);
  const std::uint64_t shown = client.lossless_frame().revision();
  EXPECT_EQ(shown, client.state().revision());
}

}  // namespace
}  // namespace isostrata
