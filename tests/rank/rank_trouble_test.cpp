// What goes wrong with launchers and ranks is said in a line, and leaves nothing behind.
#include <gtest/gtest.h>

#include "rank/by_ranks.h"

namespace isostrata::testing {
namespace {

CommandResult render(const TemporaryFolder& folder, const std::string& arguments, const std::string& ranks, const std::string& environment = "") {
  return run_isostrata("render " + arguments + " --size 64x64 --out " + quoted(folder / "out.png") + " --ranks '" + ranks + "'",
                       launcher_environment() + " " + environment);
}

TEST(RankTrouble, ALauncherThatIsMissingIsNamed) {
  const TemporaryFolder folder;
  const CommandResult run = render(folder, "torus:8", "no-such-launcher -n 4");
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("'no-such-launcher' cannot be started: No such file"), std::string::npos) << run.err;
}

TEST(RankTrouble, ALauncherThatStartsNothingIsNoSuccess) {
  const TemporaryFolder folder;
  const CommandResult run = render(folder, "torus:8", "echo rubbish");
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("was not written"), std::string::npos) << run.err;
}

TEST(RankTrouble, NoLauncherIsWrongUsage) {
  const TemporaryFolder folder;
  EXPECT_NE(render(folder, "torus:8", " ").err.find("expected the command that starts the ranks"), std::string::npos);
}

TEST(RankTrouble, WhatOneProcessRefusesRanksRefuseInTheSameWords) {
  const TemporaryFolder folder;
  for (const std::string arguments : {"no-such-file", "torus:8 --interval 3:1", "torus:8 --array none"}) {
    const CommandResult run = render(folder, arguments, launcher(2));
    const CommandResult one = run_isostrata("render " + arguments + " --size 64x64 --out " + quoted(folder / "out.png"));
    EXPECT_NE(run.status, 0) << arguments;
    const std::string said = one.err.substr(one.err.find(':') + 1);
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err << " / " << one.err;
  }
}

// The others are cancelled then: that is not what is said.
TEST(RankTrouble, AFileThatOneRankAloneMissesIsNamedWithTheRank) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_isostrata("extract torus:24 --interval 0:0.3 --out " + quoted(folder / "field.vtu")).status, 0);
  // As on a node of its own: where rank 2 begins the file is not there.
  std::filesystem::create_directory(folder / "other");
  const auto start = folder.write("start.sh", "cd '" + folder.path().string() + "'\n[ \"$OMPI_COMM_WORLD_RANK\" != 2 ] || cd other\nexec \"$@\"\n");
  const CommandResult run = render(folder, "field.vtu --interval 0:0.2", launcher(3) + " sh " + start.string());
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("isostrata-rank: rank 2 on "), std::string::npos) << run.err;
  EXPECT_NE(run.err.find(": field.vtu: "), std::string::npos) << run.err;
}

TEST(RankTrouble, ARankThatCannotGoOnEndsTheJobWithTheReason) {
  const TemporaryFolder folder;
  const CommandResult run = render(folder, "torus:8 --interval 0:0.2", launcher(3), "ISOSTRATA_RANKS_CONTROL=no-setup");
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("isostrata-rank: rank 1 on "), std::string::npos) << run.err;
  EXPECT_NE(run.err.find(": no setup, as was asked for"), std::string::npos) << run.err;
}

// By which a launcher ends what is left of its job: the first rank does not wait for replies then.
TEST(RankTrouble, TheFirstRankEndsWhenItIsAskedTo) {
  const TemporaryFolder folder;
  const auto start = folder.write("start.sh", "[ \"$OMPI_COMM_WORLD_RANK\" != 0 ] || (sleep 3; kill -TERM $$) &\nexec \"$@\"\n");
  const CommandResult run = render(folder, "torus:8 --interval 0:0.2", "timeout -s KILL 60 " + launcher(2) + " sh " + start.string(), "ISOSTRATA_RANKS_CONTROL=silent");
  EXPECT_EQ(run.status, 128 + 15) << run.err;
}

// As the launcher of another MPI does it, or srun without --mpi.
TEST(RankTrouble, ALauncherWhoseProcessesMpiDoesNotJoinIsRefused) {
  const TemporaryFolder folder;
  for (const char* said : {"PMI_SIZE=4", "SLURM_STEP_NUM_TASKS=4"}) {
    const CommandResult run = render(folder, "torus:8 --interval 0:0.2", std::string("env ") + said);
    EXPECT_EQ(run.status, 1);
    EXPECT_NE(run.err.find("the launcher has started 4 processes and MPI does not join them"), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
  }
  EXPECT_EQ(render(folder, "torus:8 --interval 0:0.2", "env PMI_SIZE=1").status, 0);
}

TEST(RankTrouble, SlurmIsToldToEndAJobThatHasLostARank) {
  const TemporaryFolder folder;
  const auto say = folder.write("say.sh", "echo \"kill $SLURM_KILL_BAD_EXIT\" >&2\nexit 3\n");
  EXPECT_NE(render(folder, "torus:8", "sh " + say.string()).err.find("kill 1\n"), std::string::npos);
  EXPECT_NE(render(folder, "torus:8", "sh " + say.string(), "SLURM_KILL_BAD_EXIT=0").err.find("kill 0\n"), std::string::npos);
}

TEST(RankTrouble, AFlatGridIsRefused) {
  const TemporaryFolder folder;
  const auto file = folder.write("flat.vtk", "# vtk DataFile Version 3.0\nflat\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 1\nORIGIN 0 0 0\nSPACING 1 1 1\n"
                                             "POINT_DATA 9\nSCALARS f float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8\n");
  const CommandResult run = render(folder, quoted(file) + " --interval 1:5", launcher(2));
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("a flat grid is not shared out among ranks"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace isostrata::testing
