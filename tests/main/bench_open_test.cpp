#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cstdint>

#include "support/run_isostrata.h"
#include "support/temporary_folder.h"

namespace isostrata::testing {
namespace {

namespace json = boost::json;

std::string nrrd(int step) {
  std::string file = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n\n";
  for (int k = 0; k < 24; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i) file += static_cast<char>((i - 12) * (i - 12) / 2 + (j - 12) * (j - 12) / 2 + (k - 12 + step) * (k - 12 + step) / 4);
  return file;
}

TEST(BenchOpen, SaysWhatTheFirstPictureTookAndLeavesNothingBehind) {
  TemporaryFolder folder;
  const auto file = folder.write("field.nrrd", nrrd(0));
  const auto temporary = folder.path() / "tmp";
  std::filesystem::create_directory(temporary);
  const CommandResult result =
      run_isostrata("bench open --json --repeat 1 --size 160x120 --data '" + file.string() + "' torus:16", "TMPDIR='" + temporary.string() + "' ");
  ASSERT_EQ(result.status, 0) << result.err;
  const json::array runs = json::parse(result.out).at("runs").as_array();
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].at("data").as_string(), "field.nrrd");
  EXPECT_EQ(runs[0].at("bytes").to_number<std::uint64_t>(), std::filesystem::file_size(file));
  EXPECT_GT(runs[0].at("temporary_mb").to_number<double>(), 0) << "a small file is copied into the cache";
  EXPECT_EQ(runs[1].at("bytes").to_number<std::uint64_t>(), 0u);
  EXPECT_EQ(runs[1].at("temporary_mb").to_number<double>(), 0);
  for (const json::value& run : runs) {
    EXPECT_GT(run.at("cold_ms").to_number<double>(), 0);
    EXPECT_GT(run.at("warm_ms").to_number<double>(), 0);
    EXPECT_GE(run.at("resident_mb").to_number<double>(), 0);
    EXPECT_GT(run.at("tetrahedra").to_number<std::int64_t>(), 100);
  }
  EXPECT_TRUE(std::filesystem::is_empty(temporary));
  EXPECT_EQ(run_isostrata("bench open --data /nowhere/at-all.vti").status, 1);
}

TEST(BenchPlay, PlaysTheStepsOfASeries) {
  TemporaryFolder folder;
  for (int step = 0; step < 4; ++step) folder.write("step_" + std::to_string(step) + ".nrrd", nrrd(step));
  const std::string pattern = (folder.path() / "step_*.nrrd").string();
  const CommandResult result = run_isostrata("bench play --json --repeat 1 --size 160x120 --data '" + pattern + "' cylinder:16x16x8x3 --steps 3");
  ASSERT_EQ(result.status, 0) << result.err;
  const json::array runs = json::parse(result.out).at("runs").as_array();
  ASSERT_EQ(runs.size(), 2u);
  for (const json::value& run : runs) {
    EXPECT_EQ(run.at("steps").to_number<int>(), 3);
    EXPECT_GT(run.at("steps_per_second").at("cold").to_number<double>(), 0);
    EXPECT_GT(run.at("steps_per_second").at("warm").to_number<double>(), 0);
    EXPECT_GT(run.at("tetrahedra").to_number<std::int64_t>(), 100);
  }
}

}  // namespace
}  // namespace isostrata::testing
