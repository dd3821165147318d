#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cstdint>

#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;

boost::json::value parsed(const CommandResult& result) {
  EXPECT_EQ(result.status, 0) << result.err;
  return boost::json::parse(result.out);
}

TEST(CacheCommand, SaysWhereAndHowMuch) {
  const auto document = parsed(run_isostrata("cache --json", "ISOSTRATA_CACHE=/nowhere/that/is ISOSTRATA_CACHE_SIZE=3GB"));
  EXPECT_EQ(document.at("folder"), "/nowhere/that/is");
  EXPECT_EQ(document.at("max_bytes").as_int64(), std::int64_t{3} << 30);
  EXPECT_EQ(document.at("entries").as_int64(), 0);
}

TEST(CacheCommand, IsInTheHomeDirectoryByDefault) {
  EXPECT_EQ(parsed(run_isostrata("cache --json", "ISOSTRATA_CACHE= XDG_CACHE_HOME=/some/cache")).at("folder"), "/some/cache/isostrata");
  EXPECT_EQ(parsed(run_isostrata("cache --json", "ISOSTRATA_CACHE= XDG_CACHE_HOME= HOME=/of/her")).at("folder"), "/of/her/.cache/isostrata");
}

TEST(CacheCommand, OffIsSaid) {
  EXPECT_TRUE(parsed(run_isostrata("cache --json", "ISOSTRATA_CACHE=off")).at("folder").is_null());
  EXPECT_NE(run_isostrata("cache", "ISOSTRATA_CACHE=off").out.find("nothing is kept"), std::string::npos);
}

TEST(CacheCommand, ASizeThatIsNoneIsRefusedByEveryCommand) {
  for (const char* size : {"much", "-1", "'4 apples'", "99999999999999999999GB"})
    for (const char* command : {"cache", "info torus:8"}) {
      const CommandResult result = run_isostrata(command, std::string("ISOSTRATA_CACHE=/tmp ISOSTRATA_CACHE_SIZE=") + size);
      EXPECT_EQ(result.status, 1) << size;
      EXPECT_NE(result.err.find("ISOSTRATA_CACHE_SIZE is '"), std::string::npos) << result.err;
    }
}

}  // namespace
