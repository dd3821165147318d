// The paper's modes on the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <tuple>
#include <utility>

#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;

std::string picture(const std::string& arguments, const std::filesystem::path& out) {
  const CommandResult result =
      run_isostrata("render " + arguments + " --size 48x36 --device native --out '" + out.string() + "'");
  EXPECT_EQ(result.status, 0) << arguments << ": " << result.err;
  return read_text(out);
}

TEST(RenderModes, EverySurfaceLookChangesThePicture) {
  const TemporaryFolder folder;
  std::set<std::string> pictures;
  const char* looks[] = {"",
                         ",surface=lower",
                         ",surface=upper",
                         ",surface=both",
                         ",surface=lower+domain",
                         ",surface=both,surface-opacity=0.4",
                         ",surface=both,surface-color=#00ff00",
                         ",surface=both,silhouette=0.9",
                         ",surface=both,specular=1",
                         ",surface=both,specular=1,shininess=3",
                         ",surface=both,texture=stripes,repeat=9",
                         ",surface=both,texture=viridis",
                         ",opacity=0..0.9"};
  for (const char* look : looks)
    pictures.insert(
        picture(std::string("cylinder:16x12x8 --array Density --texture Energy --interval 0.985:1.0") + look, folder / "a.png"));
  EXPECT_EQ(pictures.size(), std::size(looks));
  // A look alone means both ends.
  EXPECT_EQ(picture("torus:12 --interval 0.2:0.3,silhouette=1", folder / "a.png"),
            picture("torus:12 --interval 0.2:0.3,surface=both,silhouette=1", folder / "b.png"));
}

TEST(RenderModes, SurfacesGoWithPrioritiesAndTerms) {
  const TemporaryFolder folder;
  const std::string two =
      "torus:12 --interval 0.1:0.2,surface=upper,priority=1 --interval 0.3:0.5,surface=both,surface-opacity=0.5 ";
  EXPECT_NE(picture(two, folder / "a.png"), picture(two + "--mode prioritized", folder / "b.png"));
  const std::string combined = "cylinder:16x12x8 --array Density --interval 0.97:1.0,surface=all --and ";
  EXPECT_NE(picture(combined + "Energy=78.5:79.5", folder / "a.png"), picture(combined + "Energy=78.5:80", folder / "b.png"));
}

TEST(RenderModes, ACycleIsItsIntervalsOneByOne) {
  const TemporaryFolder folder;
  const std::string three = "torus:12 --interval 0.1:0.2 --interval 0.2:0.3 --interval 0.4:0.5 --mode cycled";
  const CommandResult result = run_isostrata("render " + three + " --size 48x36 --device native --json --out '" +
                                             (folder / "frame-%02d.png").string() + "'");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(boost::json::parse(result.out).at("pictures").as_array().size(), 3u);
  for (const auto& [file, phase, alone] : {std::tuple{"frame-00.png", "0", "0.1:0.2 --interval 0.2:0.3,opacity=0"},
                                           {"frame-01.png", "1.5", "0.1:0.2,opacity=0 --interval 0.2:0.3"}}) {
    EXPECT_EQ(read_text(folder / file), picture(three + " --phase " + phase, folder / "phase.png"));
    EXPECT_EQ(read_text(folder / file),
              picture(std::string("torus:12 --interval ") + alone + " --interval 0.4:0.5,opacity=0", folder / "alone.png"))
        << file;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "frame-02.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "frame-03.png"));
  EXPECT_THAT(picture(three, folder / "all.png"), AllOf(HasSubstr("acTL"), HasSubstr("fdAT")));
}

TEST(RenderModes, ASmearShowsItsStepsLaterOnesOverEarlierOnes) {
  const TemporaryFolder folder;
  const std::string data = "cylinder:16x12x8x4 --array Density --interval 0.97:0.99,opacity=0.9 --mode smear --steps ";
  const std::string forward = picture(data + "0,1,2 --smear-colors '#ff0000,#00ff00,#0000ff'", folder / "a.png");
  EXPECT_EQ(picture(data + "0:2 --smear-colors '#ff0000,#00ff00,#0000ff'", folder / "b.png"), forward);
  EXPECT_NE(picture(data + "2,1,0 --smear-colors '#0000ff,#00ff00,#ff0000'", folder / "c.png"), forward);
  EXPECT_EQ(
      picture(data + "2 --smear-colors '#0000ff'", folder / "d.png"),
      picture("cylinder:16x12x8x4 --array Density --interval 0.97:0.99,opacity=0.9,color=#0000ff --step 2", folder / "e.png"));
}

TEST(RenderModes, ASmearOfTimesShowsThemAlsoBetweenSteps) {
  const TemporaryFolder folder;
  const std::string data = "cylinder:16x12x8x4 --array Density --interval 0.97:0.99,opacity=0.9 --mode smear ";
  EXPECT_EQ(picture(data + "--times 0", folder / "a.png"), picture(data + "--steps 0", folder / "b.png"));
  const std::string nearest = picture(data + "--times 0,0.3", folder / "c.png");
  EXPECT_EQ(nearest, picture(data + "--steps 0,1", folder / "d.png"));
  const std::string between = picture(data + "--times 0,0.3 --time-mode interpolate", folder / "e.png");
  EXPECT_NE(between, nearest);
  EXPECT_EQ(picture(data + "--times 0.3 --time-mode interpolate --smear-colors '#0000ff'", folder / "f.png"),
            picture("cylinder:16x12x8x4 --array Density --interval 0.97:0.99,opacity=0.9,color=#0000ff --time 0.3 --time-mode interpolate",
                    folder / "g.png"));
}

TEST(RenderModes, AFilmIsItsStepsOneByOne) {
  const TemporaryFolder folder;
  const std::string scene = "cylinder:16x12x8x5 --array Density --interval 0.98:0.99 --camera +z ";
  const CommandResult film = run_isostrata("render " + scene + "--steps 0:4:2 --size 48x36 --device native --out '" + (folder / "film-%02d.png").string() + "'");
  ASSERT_EQ(film.status, 0) << film.err;
  EXPECT_THAT(film.out, HasSubstr("3 pictures"));
  std::set<std::string> pictures;
  for (const char* step : {"0", "2", "4"}) {
    const std::string one = picture(scene + "--step " + step, folder / "one.png");
    EXPECT_EQ(one, read_text(folder / (std::string("film-0") + step + ".png"))) << "step " << step;
    pictures.insert(one);
  }
  EXPECT_EQ(pictures.size(), 3u) << "the flow moves";
  EXPECT_FALSE(std::filesystem::exists(folder / "film-01.png"));
  EXPECT_THAT(picture(scene + "--steps 0,3", folder / "all.png"), AllOf(HasSubstr("acTL"), HasSubstr("fdAT")));
}

TEST(RenderModes, ATransferFunctionIsTheIntervalsBetweenItsPoints) {
  const TemporaryFolder folder;
  std::ofstream(folder / "t.json") << R"({"points":[{"value":0.1,"color":"#ff0000","opacity":0.8},
      {"value":0.3,"color":"#ff0000","opacity":0.8},{"value":0.3,"color":"#0000ff","opacity":0.2},
      {"value":0.5,"color":"#0000ff","opacity":0.2}]})";
  EXPECT_EQ(picture("torus:12 --transfer '" + (folder / "t.json").string() + "'", folder / "a.png"),
            picture("torus:12 --interval 0.1:0.3,color=#ff0000,opacity=0.8 --interval 0.3:0.5,color=#0000ff,opacity=0.2",
                    folder / "b.png"));
  std::ofstream(folder / "t.txt") << "0 0 0\n0.5 0.5 0.5\n1 1 1\n";
  EXPECT_EQ(picture("torus:12 --transfer '" + (folder / "t.txt").string() + "'", folder / "c.png"),
            picture("torus:12 --transfer '" + (folder / "t.txt").string() + "' --color-by distance", folder / "d.png"));
}

TEST(RenderModes, RefuseWithOneClearLine) {
  const TemporaryFolder folder;
  const auto write = [&](const char* name, const char* text) {
    std::ofstream(folder / name) << text;
    return "--out a.png --transfer '" + (folder / name).string() + "'";
  };
  const std::pair<std::string, const char*> refusals[] = {
      {"--out a.png --interval 0:1,surface=inside", "surface 'inside'"},
      {"--out a.png --interval 0:1,silhouette=2", "silhouette must be in [0, 1]"},
      {"--out a.png --interval 0:1,texture=wallpaper", "colour map 'wallpaper'"},
      {"--out a.png --interval 0:1,opacity=0.1..", "opacity '' is not a number"},
      {"--out a.png --interval 0:1,opacity=0.1..3", "opacity must be in [0, 1]"},
      {"--out a.png --interval 0:1,shininess=0", "shininess must be in [1, 1000]"},
      {"--out a.png --interval 0:1,surface=both,texture=stripes --texture missing", "missing"},
      {"--out a.jpg --mode cycled", "only .png and .webm hold"},
      {"--out a-%s.png --mode cycled", "expected one %d"},
      {"--out a.png --mode cycled --phase 9", "--phase 9"},
      {"--out a.png --phase 1", "goes with --mode cycled"},
      {"--out a.png --mode smear", "needs --steps"},
      {"--out a.png --mode smear --steps 0,x", "steps '0,x'"},
      {"--out a.png --mode smear --steps 0:9:0", "steps '0:9:0'"},
      {"--out a.png --mode smear --steps 0,7", "7"},
      {"--out a.png --times 0", "go with --mode smear"},
      {"--out a.jpg --steps 0:1", "only .png and .webm hold them in one file"},
      {"--out a.png --steps 0:1 --mode cycled", "expected one of them"},
      {write("1.json", "{"), "not JSON"},
      {write("2.json", "[{\"value\":1}]"), "point 0: expected a text 'color'"},
      {write("3.json", "[{\"value\":1,\"color\":\"#fff\",\"opacity\":1}]"), "1 points; expected two or more"},
      {write("4.txt", "0 0 0\n0 0\n"), "line 2"},
      {write("5.txt", "0 0 0\n2 0 0\n"), "colour is not in [0, 1]"},
      {"--out a.png --transfer /nonexistent.json", "/nonexistent.json"},
  };
  for (const auto& [arguments, says] : refusals) {
    const CommandResult result = run_isostrata("render tets:6 --device native " + arguments);
    EXPECT_EQ(result.status, 1) << arguments;
    EXPECT_THAT(result.err, HasSubstr(says)) << arguments;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
}

}  // namespace
