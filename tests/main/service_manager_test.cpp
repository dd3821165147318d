// What a service manager (systemd) passes to the real server and hears from it, by the test as the manager: sd_listen_fds(3), sd_notify(3).
#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "support/run_isostrata.h"

extern char** environ;

namespace {

namespace fs = std::filesystem;
using namespace isostrata::testing;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A socket of the test's.
struct Descriptor {
  int of;
  explicit Descriptor(int descriptor) : of(descriptor) {}
  ~Descriptor() { close(of); }
  Descriptor(const Descriptor&) = delete;
};

sockaddr_un address_of(const fs::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.string().copy(address.sun_path, sizeof address.sun_path - 1);
  return address;
}

int bound_unix(const fs::path& path, int type) {
  const int made = socket(AF_UNIX, type | SOCK_CLOEXEC, 0);
  const sockaddr_un address = address_of(path);
  EXPECT_EQ(bind(made, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << path;
  return made;
}

class Manager : public ::testing::Test {
 protected:
  ~Manager() override {
    if (server_ > 0) {
      kill(server_, SIGKILL);
      waitpid(server_, nullptr, 0);
    }
  }

  /// `isostrata serve torus:8` with the test's variables; `passed` becomes its descriptor 3. Its own LISTEN_PID only its shell knows.
  void serve(std::map<std::string, std::string> variables, int passed, const std::string& pid = "$$") {
    const std::string script = "LISTEN_PID=" + pid + " exec '" + isostrata::places::binaries() +
                               "/isostrata' serve torus:8 --no-auth --port 0 --state-dir none --renderer native --device native --ready-file '" +
                               (folder_ / "ready").string() + "' >'" + (folder_ / "out").string() + "' 2>'" + (folder_ / "err").string() + "'";
    std::vector<std::string> settings;
    for (char** of = environ; *of; ++of) settings.emplace_back(*of);
    for (const auto& [name, value] : variables) settings.push_back(name + "=" + value);
    std::vector<char*> environment;
    for (std::string& setting : settings) environment.push_back(setting.data());
    environment.push_back(nullptr);
    std::vector<std::string> words{"/bin/sh", "-c", script};
    char* const argv[] = {words[0].data(), words[1].data(), words[2].data(), nullptr};
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    if (passed >= 0) posix_spawn_file_actions_adddup2(&files, passed, 3);
    ASSERT_EQ(posix_spawn(&server_, argv[0], &files, nullptr, argv, environment.data()), 0);
    posix_spawn_file_actions_destroy(&files);
  }
  int end_of_server() {
    int status = 0;
    waitpid(server_, &status, 0);
    server_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  int stop() {
    kill(server_, SIGTERM);
    return end_of_server();
  }
  std::string errors() const { return read_text(folder_ / "err"); }

  /// The next state that it is told; empty if none comes in a minute.
  std::string told() {
    pollfd waits{notify_.of, POLLIN, 0};
    if (poll(&waits, 1, 60000) != 1) return "";
    char text[1024];
    const ssize_t got = recv(notify_.of, text, sizeof text, 0);
    return {text, static_cast<std::size_t>(std::max<ssize_t>(got, 0))};
  }
  std::string told_but_for_the_pulse() {
    std::string state = told();
    while (state == "WATCHDOG=1") state = told();
    return state;
  }

  TemporaryFolder folder_;
  Descriptor notify_{bound_unix(folder_ / "notify", SOCK_DGRAM)};
  pid_t server_ = -1;
};

/// The first line of what a server says to whoever connects there.
std::string answer_at(const sockaddr* address, socklen_t size) {
  const Descriptor client(socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (connect(client.of, address, size) != 0) return "nobody listens";
  const std::string ask = "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  EXPECT_EQ(send(client.of, ask.data(), ask.size(), 0), static_cast<ssize_t>(ask.size()));
  char text[256];
  const ssize_t got = recv(client.of, text, sizeof text, 0);
  return std::string(text, static_cast<std::size_t>(std::max<ssize_t>(got, 0))).substr(0, 15);
}

TEST_F(Manager, AConnectionThatWaitedAtThePassedPortIsAnsweredAndTheManagerHearsFromBeginningToEnd) {
  const Descriptor listening(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(listening.of, reinterpret_cast<const sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(listening.of, 16), 0);
  ASSERT_EQ(getsockname(listening.of, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const std::string port = std::to_string(ntohs(address.sin_port));

  serve({{"LISTEN_FDS", "1"}, {"NOTIFY_SOCKET", (folder_ / "notify").string()}}, listening.of);
  EXPECT_EQ(answer_at(reinterpret_cast<const sockaddr*>(&address), size), "HTTP/1.1 200 OK") << errors();
  const std::string ready = told();
  EXPECT_THAT(ready, StartsWith("READY=1\nSTATUS=serving 1 datasets on CPU")) << errors();
  EXPECT_THAT(read_text(folder_ / "ready"), HasSubstr("\"url\":\"http://127.0.0.1:" + port + "/\""));
  EXPECT_EQ(stop(), 0) << errors();
  EXPECT_EQ(told(), "STOPPING=1\nSTATUS=the server was asked to end");
}

TEST_F(Manager, APassedUnixSocketStaysWhenTheServerHasEnded) {
  const fs::path path = folder_ / "socket";
  const Descriptor listening(bound_unix(path, SOCK_STREAM));
  ASSERT_EQ(listen(listening.of, 16), 0);
  serve({{"LISTEN_FDS", "1"}}, listening.of);
  const sockaddr_un address = address_of(path);
  EXPECT_EQ(answer_at(reinterpret_cast<const sockaddr*>(&address), sizeof address), "HTTP/1.1 200 OK") << errors();
  EXPECT_EQ(stop(), 0);
  EXPECT_TRUE(fs::exists(path));
}

TEST_F(Manager, AWatchdogHearsThePulseForAsLongAsTheServerLives) {
  serve({{"NOTIFY_SOCKET", (folder_ / "notify").string()}, {"WATCHDOG_USEC", "100000"}}, -1, "0");
  EXPECT_THAT(told_but_for_the_pulse(), StartsWith("READY=1")) << errors();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(told(), "WATCHDOG=1") << errors();
  kill(server_, SIGSTOP);
  for (int status = 0; waitpid(server_, &status, WUNTRACED) == server_ && !WIFSTOPPED(status);) {
  }
  char text[64];
  while (recv(notify_.of, text, sizeof text, MSG_DONTWAIT) > 0) {
  }
  pollfd waits{notify_.of, POLLIN, 0};
  EXPECT_EQ(poll(&waits, 1, 500), 0) << "a server that stands still has no pulse";
  kill(server_, SIGCONT);
  EXPECT_EQ(told(), "WATCHDOG=1");
  EXPECT_EQ(stop(), 0);
}

TEST_F(Manager, WhatTheServerStartsIsToldNothingOfTheManager) {
  serve({{"NOTIFY_SOCKET", (folder_ / "notify").string()}, {"WATCHDOG_USEC", "60000000"}, {"LISTEN_FDS", "0"}}, -1, "0");
  EXPECT_THAT(told_but_for_the_pulse(), StartsWith("READY=1")) << errors();
  const std::string ready = read_text(folder_ / "ready");
  const auto at = ready.find("\"worker\":");
  ASSERT_NE(at, std::string::npos);
  const std::string environment = read_text("/proc/" + std::to_string(std::stol(ready.substr(at + 9))) + "/environ");
  EXPECT_THAT(environment, HasSubstr("PATH="));
  for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "LISTEN_FDS", "LISTEN_PID"}) EXPECT_EQ(environment.find(name), std::string::npos) << name;
  EXPECT_EQ(stop(), 0);
}

TEST_F(Manager, SeveralSocketsAndOneThatDoesNotListenAreRefused) {
  serve({{"LISTEN_FDS", "2"}}, notify_.of);
  EXPECT_EQ(end_of_server(), 1);
  EXPECT_THAT(errors(), HasSubstr("passes '2' sockets ($LISTEN_FDS); expected 1"));
  serve({{"LISTEN_FDS", "1"}}, notify_.of);
  EXPECT_EQ(end_of_server(), 1);
  EXPECT_THAT(errors(), HasSubstr("is not a stream socket that listens"));
}

TEST_F(Manager, ASocketThatIsMeantForAnotherProcessIsLeftAlone) {
  serve({{"LISTEN_FDS", "1"}, {"NOTIFY_SOCKET", (folder_ / "notify").string()}}, notify_.of, "1");
  EXPECT_THAT(told(), StartsWith("READY=1")) << errors();
  EXPECT_EQ(stop(), 0);
}

}  // namespace
