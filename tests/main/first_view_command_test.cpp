// `isostrata first-view`, and `isostrata render` of what it chooses.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <string>

#include "support/run_isostrata.h"
#include "support/sample_files.h"
#include "support/temporary_folder.h"
#include "support/vtk_text.h"

namespace isostrata::testing {
namespace {

namespace json = boost::json;

TEST(FirstViewCommand, SaysWhatItChoseAndWhy) {
  const auto ran = run_isostrata("first-view torus:32 --json");
  ASSERT_EQ(ran.status, 0) << ran.err;
  const json::value chosen = json::parse(ran.out);
  EXPECT_EQ(chosen.at("array").as_string(), "distance");
  EXPECT_EQ(chosen.at("time").to_number<double>(), 0);
  ASSERT_FALSE(chosen.at("layers").as_array().empty());
  for (const json::value& layer : chosen.at("layers").as_array()) {
    EXPECT_LT(layer.at("lower").to_number<double>(), layer.at("upper").to_number<double>());
    EXPECT_EQ(layer.at("color").as_string().size(), 7u);
    EXPECT_GT(layer.at("opacity").to_number<double>(), 0);
    EXPECT_FALSE(layer.at("surface").as_string().empty());
    EXPECT_FALSE(layer.at("name").as_string().empty());
    EXPECT_FALSE(layer.at("reason").as_string().empty());
  }
  for (const char* part : {"eye", "at", "up"}) EXPECT_EQ(chosen.at("camera").at(part).as_array().size(), 3u);
  EXPECT_GT(chosen.at("camera").at("fov").to_number<double>(), 0);
  EXPECT_GT(chosen.at("light").at("shading").to_number<double>(), 0);
}

TEST(FirstViewCommand, RenderDrawsIt) {
  const TemporaryFolder folder;
  const auto out = (folder / "picture.png").string();
  for (const std::string file : {"torus:32", "cylinder:16x12x8x5", "diamond:9"}) {
    const auto chosen = json::parse(run_isostrata("first-view " + file + " --size 200x150 --json").out);
    const auto ran = run_isostrata("render " + file + " --size 200x150 --json --out " + out);
    ASSERT_EQ(ran.status, 0) << ran.err;
    const auto drawn = json::parse(ran.out);
    EXPECT_EQ(drawn.at("array"), chosen.at("array"));
    EXPECT_EQ(drawn.at("step"), chosen.at("step"));
    for (const char* part : {"eye", "at", "up", "fov"})
      EXPECT_EQ(drawn.at("camera").at(part), chosen.at("camera").at(part)) << file << " " << part;
    ASSERT_EQ(drawn.at("intervals").as_array().size(), chosen.at("layers").as_array().size());
    for (std::size_t i = 0; i < chosen.at("layers").as_array().size(); ++i) {
      const json::value &layer = chosen.at("layers").at(i), &interval = drawn.at("intervals").at(i);
      for (const char* part : {"lower", "upper", "color", "opacity"})
        EXPECT_EQ(interval.at(part), layer.at(part)) << file << " layer " << i << " " << part;
    }
  }
}

TEST(FirstViewCommand, RenderKeepsTheArrayTheStepAndTheCameraThatWereSaid) {
  const TemporaryFolder folder;
  const auto ran = run_isostrata("render cylinder:16x12x8x5 --array Energy --step 1 --camera +x --size 100x80 --json --out " +
                                 (folder / "a.png").string());
  ASSERT_EQ(ran.status, 0) << ran.err;
  const auto drawn = json::parse(ran.out);
  EXPECT_EQ(drawn.at("array").as_string(), "Energy");
  EXPECT_EQ(drawn.at("step").to_number<int>(), 1);
  EXPECT_EQ(drawn.at("camera").at("eye").at(1), drawn.at("camera").at("at").at(1)) << "from +x";
  EXPECT_FALSE(drawn.at("intervals").as_array().empty());
}

TEST(FirstViewCommand, WhatCannotBeShownGetsASentence) {
  const TemporaryFolder folder;
  std::ofstream(folder / "constant.vtk")
      << "# vtk DataFile Version 3.0\nc\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\nORIGIN 0 0 0\nSPACING 1 1 1\n"
         "POINT_DATA 27\nSCALARS flat float 1\nLOOKUP_TABLE default\n"
      << [] {
           std::string values;
           for (int i = 0; i < 27; ++i) values += "5 ";
           return values;
         }();
  const auto file = (folder / "constant.vtk").string();
  for (const std::string& command : {"first-view " + file, "render " + file + " --out " + (folder / "x.png").string()}) {
    const auto ran = run_isostrata(command);
    EXPECT_EQ(ran.status, 1);
    EXPECT_NE(ran.err.find("every array has one value everywhere"), std::string::npos) << ran.err;
  }
  EXPECT_EQ(run_isostrata("first-view torus:16 --array nothing").status, 1);
  EXPECT_EQ(run_isostrata("first-view torus:16 --nonsense").status, 2);
}

TEST(FirstViewCommand, EverySampleFileHasAPicture) {
  const TemporaryFolder folder;
  for (const SampleFile& file : write_sample_files(folder)) {
    const auto ran =
        run_isostrata("render '" + file.path.string() + "' --size 64x48 --renderer native --out " + (folder / "x.png").string());
    EXPECT_EQ(ran.status, 0) << file.path << ": " << ran.err;
  }
}

}  // namespace
}  // namespace isostrata::testing
