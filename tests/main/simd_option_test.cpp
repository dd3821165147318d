// --simd and ISOSTRATA_SIMD, as a person gives them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <set>

#include "support/places.h"
#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;

struct Levels {
  std::string used;
  std::set<std::string> available;
};

/// Of this machine, without the variable.
Levels doctor() {
  const CommandResult result = run_isostrata("doctor --json", "ISOSTRATA_SIMD=");
  EXPECT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  Levels levels{std::string(document.at("simd").at("used").as_string()), {}};
  for (const auto& level : document.at("simd").at("available").as_array()) levels.available.emplace(level.as_string());
  return levels;
}

std::string used(const std::string& arguments, const std::string& environment) {
  const CommandResult result = run_isostrata("extract torus:8 --interval 0.2:0.4 --json " + arguments, environment);
  EXPECT_EQ(result.status, 0) << result.err;
  return std::string(boost::json::parse(result.out).at("simd").as_string());
}

TEST(SimdOption, DoctorNamesTheLevelAndThoseOfTheMachineAndWhatIsMissingIsRefused) {
  const Levels best = doctor();
  EXPECT_TRUE(best.available.contains(best.used));
  EXPECT_TRUE(best.available.contains("emulated"));
  EXPECT_THAT(run_isostrata("doctor --simd emulated").out, HasSubstr("used: emulated; this machine has "));
  EXPECT_EQ(used("", "ISOSTRATA_SIMD="), best.used);
  EXPECT_EQ(used("", "ISOSTRATA_SIMD=emulated"), "emulated");
  EXPECT_EQ(used("--simd auto", "ISOSTRATA_SIMD=emulated"), best.used) << "the option comes before the environment";
  for (const char* level : {"avx512", "avx2", "sse4"})
    if (!best.available.contains(level)) {
      const CommandResult missing = run_isostrata(std::string("info torus:8 --simd ") + level);
      EXPECT_EQ(missing.status, 1);
      EXPECT_THAT(missing.err, HasSubstr("SIMD level '" + std::string(level) + "': this machine does not have it; it has "));
    }
}

TEST(SimdOption, CommandsUseTheLevelAndSayWhich) {
  const TemporaryFolder folder;
  const std::string to = "--out '" + (folder / "a.png").string() + "'";
  for (const std::string command :
       {"extract torus:8 --interval 0.2:0.4 --json", "bench extract --data torus:8 --repeat 1 --json",
        "bench render --data torus:8 --size 32x32 --renderer native --repeat 1 --json"}) {
    const CommandResult result = run_isostrata(command + " --simd emulated");
    ASSERT_EQ(result.status, 0) << command << ": " << result.err;
    EXPECT_EQ(boost::json::parse(result.out).at("simd").as_string(), "emulated") << command;
  }
  const CommandResult drawn =
      run_isostrata("render torus:8 --size 32x32 --renderer native --json --simd emulated " + to);
  ASSERT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_THAT(std::string(boost::json::parse(drawn.out).at("device").as_string()), HasSubstr("CPU (emulated"));
}

TEST(SimdOption, PeerBenchHasIt) {
  if (!std::filesystem::exists(isostrata::places::binaries() + "/isostrata-peer-bench")) GTEST_SKIP() << "built without VTK";
  const CommandResult result = run_program("isostrata-peer-bench", "extract --data torus:8 --json --simd emulated");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(boost::json::parse(result.out).at("simd").as_string(), "emulated");
}

TEST(SimdOption, WhatIsNoLevelIsRefusedByName) {
  const CommandResult unknown = run_isostrata("info torus:8 --simd mmx");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.err, HasSubstr("SIMD level 'mmx': expected auto, avx512, avx2, sse4, emulated"));
  const CommandResult environment = run_isostrata("info torus:8", "ISOSTRATA_SIMD=mmx");
  EXPECT_EQ(environment.status, 1);
  EXPECT_THAT(environment.err, HasSubstr("ISOSTRATA_SIMD: SIMD level 'mmx'"));
}

}  // namespace
