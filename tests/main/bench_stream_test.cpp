#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "support/run_isostrata.h"

namespace isostrata::testing {
namespace {

namespace json = boost::json;

TEST(BenchStream, SaysOfEachLinkWhatAViewerGotAndThatRestIsWhatRenderDraws) {
  const CommandResult result = run_isostrata(
      "bench stream --json --data torus:16 --interval 0.1:0.3 --size 160x120 --seconds 0.6 --link loopback "
      "--link 10ms-20mbit-to-10mbit --viewers 1 --silent 1");
  ASSERT_EQ(result.status, 0) << result.err;
  const json::array runs = json::parse(result.out).at("runs").as_array();
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].at("link").as_string(), "loopback");
  for (const json::value& run : runs) {
    EXPECT_EQ(json::serialize(run.at("size")), "[160,120]");
    EXPECT_GT(run.at("fps").to_number<double>(), 0);
    const auto ms = [&](const char* key) { return run.at("input_to_decoded_ms").at(key).to_number<double>(); };
    EXPECT_GT(ms("p50"), 0);
    EXPECT_LE(ms("p50"), ms("p95"));
    EXPECT_LE(ms("p95"), ms("max"));
    EXPECT_GT(run.at("bytes_per_frame").to_number<double>(), 0);
    EXPECT_GT(run.at("stale_max_ms").to_number<double>(), 0);
    EXPECT_GT(run.at("rest_to_lossless_ms").to_number<double>(), 0);
    EXPECT_EQ(run.at("lossless_differs").to_number<int>(), 0);
  }
  // What crosses a link of 10 ms takes 10 ms.
  EXPECT_GE(runs[1].at("input_to_decoded_ms").at("p50").to_number<double>(), 10);
  EXPECT_TRUE(runs[1].as_object().contains("after_2s_ms"));
}

TEST(BenchStream, WithoutAnIntervalThereIsSomethingToLookAt) {
  const CommandResult result = run_isostrata("bench stream --json --data torus:24 --size 160x120 --seconds 0.5 --link loopback");
  ASSERT_EQ(result.status, 0) << result.err;
  const json::object run = json::parse(result.out).at("runs").as_array().at(0).as_object();
  EXPECT_GT(run.at("tetrahedra").to_number<double>(), 1000);
  EXPECT_EQ(run.at("lossless_differs").to_number<int>(), 0);
}

TEST(BenchStream, HoldsOnToTheCodecThatIsNamed) {
  for (const std::string codec : {"jpeg", "vp9-444"}) {
    const CommandResult result =
        run_isostrata("bench stream --json --data torus:16 --size 160x120 --seconds 0.5 --link loopback --codec " + codec);
    ASSERT_EQ(result.status, 0) << result.err;
    json::object codecs = json::parse(result.out).at("runs").as_array().at(0).at("codecs").as_object();
    codecs.erase("png");  // of a rest in between
    if (codec != "jpeg") codecs.erase("jpeg");  // until the video encoder is open
    EXPECT_EQ(codecs.size(), 1u) << json::serialize(codecs);
    EXPECT_TRUE(codecs.contains(codec)) << json::serialize(codecs);
  }
}

TEST(BenchStream, RefusesALinkThatItCannotMake) {
  for (const char* link : {"fast", "40ms-20", "40ms-20mbit-to", "0mbit"}) {
    const CommandResult result = run_isostrata(std::string("bench stream --link '") + link + "'");
    EXPECT_NE(result.status, 0) << link;
    EXPECT_NE(result.err.find("link"), std::string::npos) << result.err;
  }
}

}  // namespace
}  // namespace isostrata::testing
