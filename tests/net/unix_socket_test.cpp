// A server at a Unix socket: who may connect, what it leaves, and clients that come that way.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "net/running_server.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

int connected(const fs::path& path) {
  const int end = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  path.string().copy(name.sun_path, sizeof name.sun_path - 1);
  if (connect(end, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0) return end;
  close(end);
  return -1;
}

std::string asked(const fs::path& path, const std::string& request) {
  const int end = connected(path);
  std::string answer;
  if (end < 0 || send(end, request.data(), request.size(), MSG_NOSIGNAL) < 0) return answer;
  char buffer[4096];
  for (ssize_t n = 0; (n = recv(end, buffer, sizeof buffer, 0)) > 0;) answer.append(buffer, static_cast<std::size_t>(n));
  close(end);
  return answer;
}

class UnixSocket : public ::testing::Test {
 protected:
  ServerOptions at_path() {
    ServerOptions options;
    options.socket = path_;
    return options;
  }
  const testing::TemporaryFolder folder_;
  const fs::path path_ = folder_ / "isostrata.sock";
};

TEST_F(UnixSocket, ServesItsUserAloneAndAsksForTheTokenAllTheSame) {
  RunningServer server(at_path());
  EXPECT_EQ(server.port(), 0) << "no port is open";
  struct stat about {};
  ASSERT_EQ(stat(path_.c_str(), &about), 0);
  EXPECT_TRUE(S_ISSOCK(about.st_mode));
  EXPECT_EQ(about.st_mode & 0777, 0600u);
  const std::string head = " HTTP/1.1\r\nHost: localhost:8080\r\nConnection: close\r\n";
  EXPECT_EQ(status_of(asked(path_, "GET /healthz" + head + "\r\n")), 200);
  EXPECT_EQ(status_of(asked(path_, "GET /api/v1/sessions" + head + "\r\n")), 401);
  EXPECT_EQ(
      status_of(asked(path_, "GET /api/v1/sessions" + head + "Authorization: Bearer " + RunningServer::kToken + "\r\n\r\n")),
      200);
}

TEST_F(UnixSocket, ClientsConnectByItsPath) {
  RunningServer server(at_path());
  client::Options options = server.client_options();
  options.url = "unix:" + path_.string() + "?token=" + RunningServer::kToken;
  client::Client client(options);
  client.open_dataset("torus-12");
  EXPECT_EQ(client.lossless_frame().width(), 64u);
  options.url = "unix:" + path_.string() + "?token=wrong";
  EXPECT_THROW(client::Client{options}, client::ClientError);
  options.url = "unix:" + (folder_ / "absent").string();
  EXPECT_THROW(client::Client{options}, client::ClientError);
}

TEST_F(UnixSocket, IsGoneWithItsServerAndReplacesWhatADeadOneLeft) {
  { RunningServer server(at_path()); }
  EXPECT_FALSE(fs::exists(path_));
  const int dead = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  path_.string().copy(name.sun_path, sizeof name.sun_path - 1);
  ASSERT_EQ(bind(dead, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  close(dead);
  ASSERT_TRUE(fs::exists(path_));
  RunningServer server(at_path());
  EXPECT_EQ(status_of(asked(path_, "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")), 200);
}

TEST_F(UnixSocket, IsRefusedWhereSomethingElseIs) {
  RunningServer server(at_path());
  EXPECT_THROW(RunningServer{at_path()}, Error) << "another server answers there";
  EXPECT_EQ(status_of(asked(path_, "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")), 200)
      << "and goes on";
  ServerOptions on_a_file;
  on_a_file.socket = folder_.write("a file", "x");
  EXPECT_THROW(RunningServer{std::move(on_a_file)}, Error);
  EXPECT_EQ(fs::file_size(folder_ / "a file"), 1u);
  ServerOptions too_long;
  too_long.socket = folder_ / std::string(200, 'x');
  EXPECT_THROW(RunningServer{std::move(too_long)}, Error);
}

}  // namespace
}  // namespace isostrata
