// What is said to somebody who mistyped a command: one line that says what, what was probably meant, and what to read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Status 2, nothing on standard output, just this line.
void expect_wrong(const std::string& arguments, const std::string& line) {
  const CommandResult result = run_isostrata(arguments);
  EXPECT_EQ(result.status, 2) << arguments;
  EXPECT_EQ(result.out, "") << arguments;
  EXPECT_EQ(result.err, line + "\n") << arguments;
}

TEST(WrongUsage, NamesTheCommandThatWasProbablyMeant) {
  expect_wrong("rendr torus --out x.png", "isostrata: there is no command 'rendr'. Did you mean 'render'? isostrata --help lists the commands.");
  expect_wrong("paint", "isostrata: there is no command 'paint'. isostrata --help lists the commands.");
}

TEST(WrongUsage, NamesTheOptionThatWasProbablyMeant) {
  expect_wrong("render torus:8 --intervall 0:1 --out x.png",
               "isostrata render: there is no option '--intervall'. Did you mean '--interval'? isostrata render --help lists what it takes.");
  expect_wrong("extract torus:8 --interval 0:1 --treads=2",
               "isostrata extract: there is no option '--treads'. Did you mean '--threads'? isostrata extract --help lists what it takes.");
  expect_wrong("info torus:8 torus:9", "isostrata info: 'torus:9' is one word too many. isostrata info --help lists what it takes.");
}

TEST(WrongUsage, SaysWhatIsMissing) {
  expect_wrong("extract torus:8", "isostrata extract: --interval is required. isostrata extract --help lists what it takes.");
  expect_wrong("--simd avx2", "isostrata: there is no option '--simd'. isostrata --help lists the commands.");
}

TEST(Help, IsWhatComesWithoutACommand) {
  const CommandResult help = run_isostrata("--help");
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.out, HasSubstr("first-view"));
  for (const char* same : {"", "help"}) {
    const CommandResult result = run_isostrata(same);
    EXPECT_EQ(result.status, 0) << same;
    EXPECT_EQ(result.out, help.out) << same;
  }
  EXPECT_EQ(run_isostrata("help render").out, run_isostrata("render --help").out);
  EXPECT_THAT(run_isostrata("-V").out, StartsWith("isostrata "));
}

TEST(MistypedNames, OfFilesArraysAndMapsAreTold) {
  const TemporaryFolder folder;
  std::ofstream(folder / "plume.vtu") << "nothing";
  const auto says = [](const std::string& arguments) {
    const CommandResult result = run_isostrata(arguments);
    EXPECT_EQ(result.status, 1) << arguments;
    return result.err;
  };
  EXPECT_THAT(says("info '" + (folder / "plum.vtu").string() + "'"), HasSubstr("no such file or analytic data. Did you mean '" + (folder / "plume.vtu").string() + "'?"));
  EXPECT_THAT(says("info toros"), HasSubstr("no such file or analytic data. Did you mean 'torus'?"));
  EXPECT_THAT(says("render torus:8 --array distence --out /tmp/x.png"), HasSubstr("it has distance. Did you mean 'distance'?"));
  EXPECT_THAT(says("render torus:8 --interval 0:1,color=map:virdis --out /tmp/x.png"), HasSubstr("Did you mean 'viridis'?"));
}

TEST(EmptyIntervals, AreTold) {
  const TemporaryFolder folder;
  const std::string picture = " --out '" + (folder / "x.png").string() + "'";
  for (const std::string& command : {"render torus:8" + picture, std::string("extract torus:8")}) {
    const CommandResult outside = run_isostrata(command + " --interval 5:6 --interval 0:0.3");
    EXPECT_EQ(outside.status, 0) << command;
    EXPECT_THAT(outside.err, StartsWith("isostrata: nothing lies in 5:6: the values of 'distance' are from 0.")) << command;
    EXPECT_EQ(std::count(outside.err.begin(), outside.err.end(), '\n'), 1) << outside.err;
    EXPECT_EQ(run_isostrata(command + " --interval 0:0.3").err, "") << command;
  }
}

}  // namespace
