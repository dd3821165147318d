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
