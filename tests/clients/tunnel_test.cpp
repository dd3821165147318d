// isostrata-client tunnel: what it makes of Slurm's words, and the line that it opens. Slurm and ssh are stand-ins here, since the law is about words;
// deploy/prove-slurm has the real ones.
#include <gtest/gtest.h>

#include <filesystem>

#include "support/served.h"

namespace isostrata::testing {
namespace {

namespace fs = std::filesystem;

class Tunnel : public ::testing::Test {
 protected:
  void stand_in(const std::string& name, const std::string& script) {
    folder_.write("bin/" + name, "#!/bin/sh\n" + script);
    fs::permissions(folder_ / "bin" / name, fs::perms::owner_all);
  }
  void job_says(const std::string& text) { folder_.write("isostrata/jobs/7", text); }
  Ended tunnel(std::vector<std::string> arguments) {
    std::vector<std::string> command{"/usr/bin/env", "PATH=" + (folder_ / "bin").string() + ":/usr/bin:/bin",
                                     "XDG_STATE_HOME=" + folder_.path().string(), Served::program("isostrata-client"), "--timeout", "1", "tunnel"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run_to_end(command);
  }
  TemporaryFolder folder_;
};

int port_of(const std::string& url) { return std::stoi(url.substr(url.rfind(':') + 1)); }

const std::string kPrinted =
    "\nOpen  http://127.0.0.1:41234/?token=abc\n\nFrom another machine, first\n      ssh -L 41234:127.0.0.1:41234 ada@node7\n\n";

TEST_F(Tunnel, SaysWhatBecameOfAJobThatDoesNotServe) {
  struct Case {
    std::string slurm, message;
  };
  const std::vector<Case> cases = {
      {"echo 'PENDING||Resources'", "job 7 waits (PENDING, Resources); try again once it runs"},
      {"echo 'CONFIGURING|node7|None'", "job 7 waits (CONFIGURING)"},
      {"echo 'COMPLETED|node7|None'", "job 7 has ended (COMPLETED)"},
      {"echo 'TIMEOUT|node7|TimeLimit'", "job 7 has ended (TIMEOUT)"},
      {"echo 'SUSPENDED|node7|None'", "job 7 stands still (SUSPENDED)"},
      {"exit 0", "Slurm does not know job 7"},
      {"echo 'slurm_load_jobs error: Invalid job id specified' >&2; exit 1", "Slurm does not know job 7"},
      {"echo 'squeue: error: Unable to contact slurm controller' >&2; exit 1", "Slurm does not answer: squeue: error: Unable to contact slurm controller"},
      {"echo 'sh: 1: squeue: not found' >&2; exit 127", "there is no squeue here; --login HOST"},
      {"case $* in *%B*) echo 'RUNNING|node7|None';; *) echo RUNNING;; esac", "job 7 runs on node7 and has written no address yet"},
  };
  stand_in("ssh", "echo 'ssh was started' >&2; exit 9");
  for (const Case& c : cases) {
    stand_in("squeue", c.slurm);
    const Ended ended = tunnel({"7"});
    EXPECT_EQ(ended.status, 1) << c.slurm;
    EXPECT_NE(ended.err.find(c.message), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("ssh was started"), std::string::npos) << c.slurm;
  }
}

TEST_F(Tunnel, TheLineLeadsToTheNodeAndItsPortThroughTheLoginNode) {
  stand_in("squeue", "case $* in *%B*) echo 'RUNNING|node7|None';; *) echo RUNNING;; esac");
  // A login brings words of its own, and a PATH.
  folder_.write(".bash_profile", "echo Welcome to the cluster; PATH=" + (folder_ / "bin").string() + ":$PATH");
  stand_in("ssh", "case $* in '-- '*) shift 2; HOME=" + folder_.path().string() + "; eval \"$*\";; *) echo \"$*\" >&2; exit 255;; esac");
  job_says(kPrinted);
  const Ended ended = tunnel({"--login", "ada@gate", "--port", "9000", "7"});
  EXPECT_EQ(ended.status, 1);
  EXPECT_NE(ended.err.find("-L 127.0.0.1:9000:127.0.0.1:41234 -J ada@gate -- ada@node7\n"), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("ssh to node7 failed with status 255"), std::string::npos) << ended.err;
  EXPECT_EQ(ended.out, "") << "no address of a line that is not there";
  EXPECT_EQ(ended.err.find("abc"), std::string::npos) << "the token is in no command line";
}

TEST_F(Tunnel, ASocketIsReachedByItsPath) {
  stand_in("squeue", "case $* in *%B*) echo 'RUNNING|node7|None';; *) echo RUNNING;; esac");
  stand_in("ssh", "echo \"$*\" >&2; exit 255");
  job_says("\nFrom your machine\n      ssh -L 8080:/scratch/ada/s node7\n\nand open  http://localhost:8080/?token=abc\n\n");
  const Ended ended = tunnel({"--port", "9000", "7"});
  EXPECT_NE(ended.err.find("-L 127.0.0.1:9000:/scratch/ada/s -- node7\n"), std::string::npos) << ended.err;
}

TEST_F(Tunnel, WhoeverHasThePortAlreadyIsNotTakenForTheServer) {
  const Served other({"torus:12"});
  ASSERT_FALSE(other.url().empty());
  const std::string port = std::to_string(port_of(other.url()));
  stand_in("squeue", "case $* in *%B*) echo 'RUNNING|node7|None';; *) echo RUNNING;; esac");
  stand_in("ssh", "exec sleep 60");
  job_says(kPrinted);
  const Ended ended = tunnel({"--port", port, "7"});
  EXPECT_EQ(ended.status, 1);
  EXPECT_EQ(ended.err, "isostrata-client: port " + port + " of this machine is taken\n");
  EXPECT_EQ(ended.out, "");
}

TEST_F(Tunnel, ALineThatLeadsToNobodyIsNamedAndEnded) {
  stand_in("squeue", "case $* in *%B*) echo 'RUNNING|node7|None';; *) echo RUNNING;; esac");
  stand_in("ssh", "echo $$ >\"$XDG_STATE_HOME/line\"; exec sleep 60");
  job_says(kPrinted);
  const Ended ended = tunnel({"7"});
  EXPECT_EQ(ended.status, 1);
  EXPECT_NE(ended.err.find("nobody answers at 127.0.0.1:41234 of node7; the log of job 7 says more"), std::string::npos) << ended.err;
  EXPECT_FALSE(fs::exists("/proc/" + std::to_string(std::stoi(read_text(folder_ / "line")))));
}

TEST_F(Tunnel, AJobIsANumber) {
  for (const std::string job : {"x", "7;ls", "$(id)", "-7"}) {
    const Ended ended = tunnel({"--", job});
    EXPECT_EQ(ended.status, 2) << job << ended.err;
  }
}

}  // namespace
}  // namespace isostrata::testing
