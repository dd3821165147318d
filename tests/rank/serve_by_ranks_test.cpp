// isostrata serve whose worker is a parallel job: its pictures, its deaths, its end.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "rank/by_ranks.h"
#include "support/read_process.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

namespace fs = std::filesystem;

struct Living {
  pid_t process = 0, parent = 0;
  std::string line;  // its arguments
};

/// All processes below this one, children of children too.
std::vector<Living> descendants() {
  std::vector<Living> all, below;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string stat = read_process(entry.path() / "stat"), line = read_process(entry.path() / "cmdline");
    const auto end = stat.rfind(')');
    if (end == std::string::npos || stat.substr(end + 2, 1) == "Z") continue;
    std::istringstream fields(stat.substr(end + 4));
    Living of{std::stoi(name), 0, line};
    fields >> of.parent;
    all.push_back(std::move(of));
  }
  std::vector<pid_t> parents{getpid()};
  for (std::size_t i = 0; i < parents.size(); ++i)
    for (const Living& of : all)
      if (of.parent == parents[i]) parents.push_back(of.process), below.push_back(of);
  return below;
}

std::vector<pid_t> ranks() {
  std::vector<pid_t> found;
  for (const Living& of : descendants())
    if (of.line.find("isostrata-rank") < of.line.find('\0')) found.push_back(of.process);
  return found;
}

std::vector<pid_t> launchers() {
  std::vector<pid_t> found;
  for (const Living& of : descendants())
    if (const std::string program = of.line.substr(0, of.line.find('\0')); program.ends_with("mpirun") || program.ends_with("prterun"))  // that of OpenMPI 5
      found.push_back(of.process);
  return found;
}

class ServeByRanks : public ::testing::Test {
 protected:
  ServeByRanks() { set_mpi_environment(); }

  /// The server's picture and that of `isostrata render` by one process are of the same layers.
  static Samples picture(const Served& server, const fs::path& out, const std::string& interval) {
    const Ended ended = server.client({"snapshot", "--dataset", "torus:20", "--interval", interval, "--size", "120x90", "--out", out.string()});
    if (ended.status != 0) throw std::runtime_error(ended.err);
    return read_exr(out);
  }

  TemporaryFolder folder_;
};

TEST_F(ServeByRanks, PicturesAreThoseOfOneProcess) {
  Served many({"torus:20", "--renderer", "native", "--ranks", launcher(3)}), one({"torus:20", "--renderer", "native"});
  ASSERT_FALSE(many.url().empty()) << many.process().err();
  ASSERT_FALSE(one.url().empty()) << one.process().err();
  EXPECT_EQ(ranks().size(), 3u);
  for (const char* interval : {"0:0.2,color=#ff2010,opacity=0.5", "0.1:0.4,color=map:viridis", "0.05:0.3,color=#2040ff,surface=both"}) {
    const Distance off = distance_of(picture(one, folder_ / "one.exr", interval), picture(many, folder_ / "many.exr", interval));
    EXPECT_GT(off.brightest, 0.05);
    EXPECT_LE(off.worst, 1e-5) << interval;
  }
  EXPECT_NE(many.process().err().find("3 ranks"), std::string::npos) << many.process().err();
  EXPECT_EQ(many.stop(SIGTERM), 0);
  one.stop(SIGTERM);
  EXPECT_TRUE(descendants().empty());
}

TEST_F(ServeByRanks, ADeadRankOrLauncherIsAWorkerThatIsReplaced) {
  Served server({"torus:20", "--renderer", "native", "--ranks", launcher(3)});
  ASSERT_FALSE(server.url().empty()) << server.process().err();
  const auto kill_one = [&](pid_t which) {
    const std::vector<pid_t> before = ranks();
    ASSERT_EQ(before.size(), 3u);
    ::kill(which, SIGKILL);
    const Samples drawn = picture(server, folder_ / "after.exr", "0:0.2,opacity=0.5");
    EXPECT_EQ(drawn.width, 120);
    const std::vector<pid_t> after = ranks();
    EXPECT_EQ(after.size(), 3u);
    for (const pid_t old : before) EXPECT_EQ(std::count(after.begin(), after.end(), old), 0);
  };
  kill_one(ranks()[0]);
  kill_one(ranks()[2]);
  ASSERT_EQ(launchers().size(), 1u);
  kill_one(launchers()[0]);
  EXPECT_NE(server.process().err().find("the renderer's process was ended by"), std::string::npos) << server.process().err();
  EXPECT_NE(server.process().err().find("signal 9"), std::string::npos) << server.process().err();
  EXPECT_EQ(server.stop(SIGTERM), 0);
  EXPECT_TRUE(descendants().empty());
}

// By which a launcher ends what is left of its job.
TEST_F(ServeByRanks, TheFirstRankEndsWhenItIsAskedTo) {
  Served server({"torus:20", "--renderer", "native", "--ranks", launcher(2)});
  ASSERT_FALSE(server.url().empty()) << server.process().err();
  const std::vector<pid_t> before = ranks();
  const pid_t first = *std::min_element(before.begin(), before.end());  // launchers start them in their order
  ::kill(first, SIGTERM);
  for (int i = 0; i < 300 && fs::exists("/proc/" + std::to_string(first)); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(fs::exists("/proc/" + std::to_string(first)));
  EXPECT_EQ(picture(server, folder_ / "after.exr", "0:0.2,opacity=0.5").width, 120);
  EXPECT_EQ(server.stop(SIGTERM), 0);
  EXPECT_TRUE(descendants().empty());
}

TEST_F(ServeByRanks, AServerThatIsKilledLeavesNoRankBehind) {
  pid_t some = 0;
  {
    Served server({"torus:12", "--renderer", "native", "--ranks", launcher(2)});
    ASSERT_FALSE(server.url().empty()) << server.process().err();
    some = ranks().at(0);
    EXPECT_EQ(server.stop(SIGKILL), 128 + SIGKILL);
  }
  for (int i = 0; i < 300 && fs::exists("/proc/" + std::to_string(some)); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(fs::exists("/proc/" + std::to_string(some)));
}

TEST_F(ServeByRanks, ALauncherThatStartsNoRankEndsTheServerWithTheReason) {
  for (const char* launcher : {"no-such-launcher", "echo rubbish", "false"}) {
    Served server({"torus:12", "--ranks", launcher});
    EXPECT_TRUE(server.url().empty());
    EXPECT_NE(server.process().wait(), 0);
    EXPECT_NE(server.process().err().find("before the first rank had begun"), std::string::npos) << server.process().err();
  }
}

}  // namespace
}  // namespace isostrata::testing
