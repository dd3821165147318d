// isostrata-client view: a server started here; what ssh is asked for, by a stand-in; and, on a machine that has sshd, a server started through a real one,
// with a configuration and keys of its own.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "support/served.h"

namespace isostrata::testing {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

bool becomes(const std::function<bool()>& so) {
  for (const auto last = std::chrono::steady_clock::now() + 60s; std::chrono::steady_clock::now() < last; std::this_thread::sleep_for(50ms))
    if (so()) return true;
  return false;
}

/// A port of this machine that was free a moment ago.
int free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  EXPECT_EQ(bind(socket, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size), 0);
  close(socket);
  return ntohs(address.sin_port);
}

/// The address that `view` prints; empty if it ends without one.
std::string url_of(Process& viewer) {
  if (!viewer.says("until Ctrl-C.\n\nOpen  http://") || !becomes([&] { return viewer.out().ends_with("\n\n"); })) return {};
  const std::string out = viewer.out();
  const auto at = out.find("http://");
  return out.substr(at, out.find('\n', at) - at);
}

/// Its status line and body.
Ended got(const std::string& url, const std::string& path) {
  const auto question = url.find('?');
  return run_to_end({"/usr/bin/curl", "--silent", "--max-time", "20", "--write-out", "%{http_code}", url.substr(0, question) + path + url.substr(question)});
}

class View : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.write("seen", "");
    stand_in("xdg-open", "printf '%s' \"$1\" >'" + (folder_ / "seen").string() + "'");
  }
  void stand_in(const std::string& name, const std::string& script) {
    folder_.write("bin/" + name, "#!/bin/sh\n" + script + "\n");
    fs::permissions(folder_ / "bin" / name, fs::perms::owner_all);
  }
  std::vector<std::string> view(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command{"/usr/bin/env", "PATH=" + (folder_ / "bin").string() + ":/usr/local/bin:/usr/bin:/bin", "BROWSER=any",
                                     "XDG_STATE_HOME=" + (folder_ / "state").string(), Served::program("isostrata-client"), "view"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return command;
  }

  TemporaryFolder folder_;
};

/// An sshd of this user alone.
class SshdView : public View {
 protected:
  void SetUp() override {
    View::SetUp();
    ASSERT_EQ(run_to_end({"/usr/bin/ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", (folder_ / "host").string()}).status, 0);
    ASSERT_EQ(run_to_end({"/usr/bin/ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", (folder_ / "user").string()}).status, 0);
    if (geteuid() == 0) mkdir("/run/sshd", 0755);  // sshd wants it of root
    const int port = free_port();
    const std::string at = folder_.path().string();
    folder_.write("sshd_config", "Port " + std::to_string(port) + "\nListenAddress 127.0.0.1\nHostKey " + at + "/host\nAuthorizedKeysFile " + at +
                                     "/user.pub\nStrictModes no\nUsePAM no\nPasswordAuthentication no\nPidFile " + at + "/sshd.pid\nPermitRootLogin yes\n");
    folder_.write("ssh_config", "Host node\n  HostName 127.0.0.1\n  Port " + std::to_string(port) + "\n  IdentityFile " + at +
                                    "/user\n  StrictHostKeyChecking no\n  UserKnownHostsFile /dev/null\n  LogLevel ERROR\n");
    stand_in("ssh", "exec /usr/bin/ssh -F '" + at + "/ssh_config' \"$@\"");
    ASSERT_EQ(run_to_end({"/usr/sbin/sshd", "-f", at + "/sshd_config", "-E", at + "/sshd.log"}).status, 0) << read_text(folder_ / "sshd.log");
    ASSERT_TRUE(becomes([&] { return fs::exists(folder_ / "sshd.pid"); }));
  }
  void TearDown() override {
    if (const std::string pid = read_text(folder_ / "sshd.pid"); !pid.empty()) kill(std::atoi(pid.c_str()), SIGTERM);
  }
};

TEST_F(View, StartsAServerHereOpensTheBrowserAndEndsIt) {
  Process viewer(view({"torus:8"}));
  const std::string url = url_of(viewer);
  ASSERT_NE(url, "") << viewer.err();
  EXPECT_TRUE(becomes([&] { return read_text(folder_ / "seen") == url; })) << read_text(folder_ / "seen");
  EXPECT_NE(got(url, "api/v1/datasets").out.find("torus:8"), std::string::npos);
  viewer.signal(SIGINT);
  EXPECT_EQ(viewer.wait(), 0) << viewer.err();
  EXPECT_NE(got(url, "healthz").status, 0) << "nobody listens there any more";
}

TEST_F(View, AsksSshForASocketThroughTheGate) {
  stand_in("ssh", "echo \"$*\" >&2; exit 255");
  const Ended ended = run_to_end(view({"ada@node:~/it's here.vti", "--jump", "gate", "--port", "9000"}));
  EXPECT_EQ(ended.status, 1);
  EXPECT_EQ(ended.out, "") << "no address of a line that is not there";
  EXPECT_NE(ended.err.find("-tt -o ExitOnForwardFailure=yes -o ServerAliveInterval=30 -L 127.0.0.1:9000:/tmp/isostrata-view-"), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find(" -J gate -- ada@node exec bash -lc 'exec "), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("ssh to ada@node ended with status 255"), std::string::npos) << ended.err;
  // What a shell makes of the words behind the host is what bash is given.
  stand_in("bash", "printf '%s' \"$2\"");
  stand_in("ssh", "while [ \"$1\" != -- ]; do shift; done; shift 2; eval \"$*\"");
  EXPECT_NE(run_to_end(view({"node:~/it's here.vti", "--program", "/my programs/isostrata"})).err.find("exec '/my programs/isostrata' serve --socket /tmp/isostrata-view-"), std::string::npos);
  stand_in("bash", "eval \"for word in ${2#*--socket }; do last=\\$word; done\"; echo \"$last\"");
  EXPECT_NE(run_to_end(view({"node:~/it's here.vti"})).err.find("isostrata-client: node: it's here.vti"), std::string::npos);
}

TEST(Hangup, EndsAServerInOrderUnlessNohupKeepsIt) {
  Served server({"torus:8"});
  SERVED_OR_SKIP(server);
  EXPECT_EQ(server.stop(SIGHUP), 0) << server.process().err();

  Process kept({"/usr/bin/nohup", Served::program("isostrata"), "serve", "--port", "0", "--state-dir", "none", "torus:8"});
  ASSERT_TRUE(kept.says("Open  http://")) << kept.err();
  kept.signal(SIGHUP);
  std::this_thread::sleep_for(1s);
  EXPECT_FALSE(kept.ended());
  kept.signal(SIGTERM);
  EXPECT_EQ(kept.wait(), 0);
}

TEST_F(SshdView, StartsAServerOnAnotherMachineAndEndsItWithTheLine) {
  folder_.write("it's \"my\" data.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n0 1 2 3 4 5 6 7\n");
  const std::string path = folder_.path().string() + "/it's \"my\" data.nrrd";
  Process viewer(view({"node:" + path, "--program", Served::program("isostrata")}));
  const std::string url = url_of(viewer);
  ASSERT_NE(url, "") << viewer.out() << viewer.err() << read_text(folder_ / "sshd.log");
  EXPECT_EQ(url.find("http://127.0.0.1:"), 0u);
  EXPECT_NE(got(url, "api/v1/datasets").out.find("data.nrrd"), std::string::npos);
  EXPECT_TRUE(becomes([&] { return read_text(folder_ / "seen") == url; }));
  const auto servers = [&] { return run_to_end({"/usr/bin/pgrep", "-f", "serve --socket /tmp/isostrata-view-.*" + folder_.path().filename().string()}).out; };
  EXPECT_NE(servers(), "");
  viewer.signal(SIGINT);
  EXPECT_EQ(viewer.wait(), 0) << viewer.err();
  EXPECT_TRUE(becomes([&] { return servers().empty(); })) << "the server there goes on: " << servers();
}

TEST_F(SshdView, SaysWhatTheOtherMachineSays) {
  const auto refused = [&](const std::vector<std::string>& arguments) {
    const Ended ended = run_to_end(view(arguments));
    EXPECT_EQ(ended.status, 1) << ended.err;
    EXPECT_EQ(ended.out, "");
    return ended.err;
  };
  const std::string program = Served::program("isostrata");
  EXPECT_NE(refused({"node:nothing.vti", "--program", program}).find("isostrata-client: node: isostrata: nothing.vti: "), std::string::npos);
  EXPECT_NE(refused({"node:torus:8", "--program", "/nowhere/isostrata"}).find("/nowhere/isostrata"), std::string::npos);
  EXPECT_NE(refused({"nowhere-there:torus:8"}).find("ssh to nowhere-there ended with status 255"), std::string::npos);
}

}  // namespace
}  // namespace isostrata::testing
