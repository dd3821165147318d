// `isostrata info` of a series: ranges over all steps, and of each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <filesystem>

#include "support/run_isostrata.h"
#include "support/temporary_folder.h"
#include "support/vtk_text.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;
using ::testing::Not;
namespace json = boost::json;

/// A mug that is poured in: nothing but zeros at first, then up to 10 and 40, and -2 at a step between.
class Mug : public ::testing::Test {
 protected:
  Mug() {
    std::string entries;
    for (int step = 0; step < 4; ++step) {
      const std::string name = "mug" + std::to_string(step) + ".vti";
      const double top[] = {0, 10, 40, 30}, bottom[] = {0, -2, 0, 0};
      folder_.write(name, vti_text({0, 0, 0}, {2, 2, 2},
                                   data_array("heat", "Float64", std::vector<double>{bottom[step], top[step], 0, 0, 0, 0, 0, 0})));
      entries += "<DataSet timestep=\"" + std::to_string(step * 0.5) + "\" file=\"" + name + "\"/>\n";
    }
    file_ = folder_.write("mug.pvd", vtk_file("Collection", "<Collection>\n" + entries + "</Collection>\n")).string();
  }
  json::value described(const std::string& options = "") {
    const CommandResult result = run_isostrata("info '" + file_ + "' --json " + options);
    EXPECT_EQ(result.status, 0) << result.err;
    return json::parse(result.out);
  }

  TemporaryFolder folder_;
  std::string file_;
};

TEST_F(Mug, HasTheRangesOfAllItsStepsWhicheverIsShown) {
  for (const char* step : {"0", "3"}) {
    const json::value info = described(std::string("--step ") + step);
    const json::value& heat = info.at("arrays").at(0);
    EXPECT_EQ(heat.at("range"), json::parse("[-2.0, 40.0]"));
    EXPECT_EQ(heat.at("step_range"), json::parse(step == std::string("0") ? "[0.0, 0.0]" : "[0.0, 30.0]"));
    EXPECT_EQ(heat.at("step_ranges"), json::parse("[[0.0, 0.0], [-2.0, 10.0], [0.0, 40.0], [0.0, 30.0]]"));
    EXPECT_EQ(info.at("range_steps"), 4);
  }
  const std::string text = run_isostrata("info '" + file_ + "'").out;
  EXPECT_THAT(text, HasSubstr("ranges over all 4 steps"));
  EXPECT_THAT(text, HasSubstr("[-2, 40]  [0, 0] at this step"));
}

TEST_F(Mug, OfOneStepReadsNoOther) {
  std::filesystem::remove(folder_ / "mug2.vti");
  const json::value info = described("--this-step --step 1");
  EXPECT_EQ(info.at("arrays").at(0).at("range"), json::parse("[-2.0, 10.0]"));
  EXPECT_EQ(info.at("arrays").at(0).at("step_ranges"), json::parse("[null, [-2.0, 10.0], null, null]"));
  EXPECT_EQ(info.at("range_steps"), 1);
  EXPECT_EQ(info.at("notes").as_array().size(), 0u);
}

TEST_F(Mug, LeavesOutAStepThatCannotBeReadAndSaysSo) {
  folder_.write("mug2.vti", "broken");
  const json::value info = described();
  EXPECT_EQ(info.at("arrays").at(0).at("range"), json::parse("[-2.0, 30.0]"));
  ASSERT_EQ(info.at("notes").as_array().size(), 1u);
  EXPECT_THAT(std::string(info.at("notes").at(0).as_string()), HasSubstr("step 2 is left out of the ranges: "));
}

}  // namespace
