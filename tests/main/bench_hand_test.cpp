#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "support/run_isostrata.h"

namespace isostrata::testing {
namespace {

namespace json = boost::json;

TEST(BenchHand, SaysOfEachDatasetHowSoonPicturesFollowAHandAndWhatRestBrings) {
  for (const std::string gesture : {"turn", "interval"}) {
    const CommandResult result =
        run_isostrata("bench hand --json --data torus:16 tets:8 --size 160x120 --seconds 0.6 --gesture " + gesture);
    ASSERT_EQ(result.status, 0) << result.err;
    const json::array runs = json::parse(result.out).at("runs").as_array();
    ASSERT_EQ(runs.size(), 2u);
    EXPECT_EQ(runs[0].at("data").as_string(), "torus:16");
    EXPECT_EQ(runs[1].at("data").as_string(), "tets:8");
    for (const json::value& run : runs) {
      EXPECT_EQ(run.at("gesture").as_string(), gesture);
      EXPECT_EQ(json::serialize(run.at("size")), "[160,120]");
      const auto ms = [&](const char* key) { return run.at("moving_ms").at(key).to_number<double>(); };
      EXPECT_GT(ms("p50"), 0);
      EXPECT_LE(ms("p50"), ms("p95"));
      EXPECT_GT(run.at("fps").to_number<double>(), 0);
      EXPECT_GT(run.at("lossless_ms").to_number<double>(), 0);
      EXPECT_GT(run.at("tetrahedra").to_number<double>(), 100);
      ASSERT_EQ(run.at("moving_size").as_array().size(), 2u);
      EXPECT_LE(run.at("moving_size").at(0).to_number<int>(), 160);
    }
  }
}

TEST(BenchHand, DataThatCannotBeMeasuredAreNamedAndTheOthersAreMeasured) {
  const CommandResult mixed = run_isostrata("bench hand --json --data /nowhere/at-all.vti torus:12 --size 80x60 --seconds 0.5");
  ASSERT_EQ(mixed.status, 0) << mixed.err;
  const json::array runs = json::parse(mixed.out).at("runs").as_array();
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_NE(runs[0].at("error").as_string().find("at-all.vti"), json::string::npos);
  EXPECT_TRUE(runs[1].as_object().contains("moving_ms"));
  EXPECT_EQ(run_isostrata("bench hand --data /nowhere/at-all.vti").status, 1);
  EXPECT_EQ(run_isostrata("bench hand --gesture wave").status, 2);
}

}  // namespace
}  // namespace isostrata::testing
