#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <boost/json.hpp>

#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;

TEST(RenderCommand, WritesEveryPictureFormat) {
  const TemporaryFolder folder;
  const std::pair<const char*, const char*> formats[] = {
      {"a.png", "\x89PNG"}, {"a.jpg", "\xff\xd8\xff"}, {"a.webp", "RIFF"}, {"a.tif", "II*"}, {"a.exr", "\x76\x2f\x31\x01"}};
  for (const auto& [name, magic] : formats) {
    const CommandResult result = run_isostrata("render tets:8 --interval 0.1:0.3 --size 64x48 --device surfaceless --out '" +
                                               (folder / name).string() + "'");
    EXPECT_EQ(result.status, 0) << name << ": " << result.err;
    EXPECT_TRUE(read_text(folder / name).starts_with(magic)) << name;
  }
}

TEST(RenderCommand, SaysWhatItDrew) {
  const TemporaryFolder folder;
  const CommandResult result = run_isostrata(
      "render torus:16 --interval 0.1:0.3,color=#ff8000,opacity=0.7,priority=2 --interval 0.5:0.7,color=map:viridis --size 64x48 "
      "--camera 'eye=3,2,1;up=0,0,1' --device surfaceless --json --out '" +
      (folder / "a.png").string() + "'");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  EXPECT_GT(document.at("tetrahedra").to_number<long>(), 1000);
  EXPECT_THAT(std::string(document.at("device").as_string()), HasSubstr("SOFTWARE"));
  EXPECT_THAT(std::string(document.at("order").as_string()), HasSubstr("index distance"));
  const auto& intervals = document.at("intervals").as_array();
  ASSERT_EQ(intervals.size(), 2u);
  EXPECT_EQ(intervals[0].at("color").as_string(), "#ff8000");
  EXPECT_EQ(intervals[0].at("priority").to_number<int>(), 2);
  EXPECT_EQ(intervals[1].at("color").as_string(), "map:viridis");
  EXPECT_EQ(document.at("camera").at("eye").as_array()[0].to_number<double>(), 3.0);
  EXPECT_EQ(document.at("camera").at("up").as_array()[2].to_number<double>(), 1.0);
}

TEST(RenderCommand, TetrahedraAreSplitOrCutAsAsked) {
  const TemporaryFolder folder;
  const auto render = [&](const std::string& options) {
    const CommandResult result = run_isostrata("render tets:8 --interval 0.1:0.3,color=map:viridis --size 64x48 --json --out '" +
                                               (folder / "a.png").string() + "' " + options);
    EXPECT_EQ(result.status, 0) << result.err;
    const auto document = boost::json::parse(result.out);
    const auto& interval = document.at("intervals").as_array().at(0);
    EXPECT_EQ(interval.at("lower").to_number<double>(), 0.1);
    return interval.at("tetrahedra").to_number<long>();
  };
  const long split = render("--renderer native"), cut = render("--renderer native --tetrahedra cut");
  EXPECT_GT(cut, 0);
  EXPECT_LT(cut, split);
  EXPECT_EQ(render("--renderer native --tetrahedra split"), split);
  EXPECT_EQ(render("--renderer raster --device surfaceless --tetrahedra cut"), split);
  EXPECT_EQ(render("--renderer native --tetrahedra cut --color-by distance"), cut);
}

TEST(BenchRender, ADragExtractsOrCuts) {
  const CommandResult result = run_isostrata(
      "bench render --drag --tetrahedra split --tetrahedra cut --data tets:8 --interval 0.1:0.3 --size 32x32 --renderer native "
      "--mode linear --repeat 3 --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  const auto& runs = document.at("runs").as_array();
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].at("way").as_string(), "split");
  EXPECT_EQ(runs[1].at("way").as_string(), "cut");
  for (const auto& run : runs) {
    EXPECT_EQ(run.at("frames").to_number<int>(), 3);
    EXPECT_GT(run.at("ms").at("extract").to_number<double>(), 0);
  }
}

struct Refusal {
  const char* arguments;
  const char* says;
};

TEST(RenderCommand, PicturesOfOwnEncodersDoWithoutOpenImageIO) {
  const TemporaryFolder folder;
  const auto render = [&](const std::string& name, const std::string& environment) {
    return run_isostrata("render tets:6 --size 32x24 --device native --out '" + (folder / name).string() + "'", environment);
  };
  for (const char* name : {"a.png", "a.webp"}) EXPECT_EQ(render(name, "ISOSTRATA_OIIO=").status, 0) << name;
  for (const char* name : {"a.exr", "a.tif", "a.jpg"}) {
    EXPECT_EQ(render(name, "").status, 0) << name;
    std::filesystem::remove(folder / name);
    const CommandResult refused = render(name, "ISOSTRATA_OIIO=");
    EXPECT_EQ(refused.status, 1) << name;
    EXPECT_NE(refused.err.find("cannot be written: OpenImageIO"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("libisostrata_oiio.so"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder / name));
  }
}

TEST(RenderCommand, RefusesWithOneClearLine) {
  const Refusal refusals[] = {
      {"--out a.bmp", "a.bmp: extension '.bmp' is not a picture"},
      {"--out a.png --size 0x10", "size '0x10'"},
      {"--out a.png --size 10x16385", "1 to 16384"},
      {"--out a.png --size 10", "expected WIDTHxHEIGHT"},
      {"--out a.png --array missing", "missing"},
      {"--out a.png --interval 3:1", "lower must be less than upper"},
      {"--out a.png --interval 0:1,color=map:none", "colour map 'none' is not built in"},
      {"--out a.png --interval 0:1,color=red", "expected #rrggbb"},
      {"--out a.png --camera sideways", "camera 'sideways'"},
      {"--out a.png --camera 'eye=0,0,0;at=0,0,0'", "eye and at must be apart"},
      {"--out a.png --background blue", "colour 'blue'"},
      {"--out a.png --unit-distance -1", "unit distance"},
      {"--out a.png --occlusion 2", "--occlusion is 2.000000; expected a number from 0 to 1"},
      {"--out a.png --body-shading 1.5", "--body-shading is 1.500000; expected a number from 0 to 1"},
      {"--out a.png --depth-fade nan", "--depth-fade is nan; expected a number from 0 to 1"},
      {"--out a.jpg --background transparent", "JPEG has no transparency"},
      {"--out a.webp --size 16384x16384", "WebP takes at most 16383 pixels"},
      {"--out a.png --clip 'w<1'", "clip 'w<1': unknown part 'w<1'"},
      {"--out a.png --clip 'x<nan'", "'nan' is not a finite number"},
      {"--out a.png --clip 'normal=0,0,0'", "the normal must not be zero"},
      {"--out a.png --clip 'offset=1'", "no normal"},
      {"--out a.png --device cuda", "device 'cuda' is not known"},
      {"--out a.png --device egl:99", "no such EGL device"},
      {"--out /nonexistent-folder/a.png", "/nonexistent-folder/a.png: cannot be written"},
  };
  for (const Refusal& refusal : refusals) {
    const CommandResult result = run_isostrata(std::string("render tets:6 ") + refusal.arguments);
    EXPECT_EQ(result.status, 1) << refusal.arguments;
    EXPECT_THAT(result.err, HasSubstr(refusal.says)) << refusal.arguments;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(result.out, "") << refusal.arguments;
  }
}

TEST(RenderCommand, DrawsAnnotationsSamplesAndClipPlanes) {
  const TemporaryFolder folder;
  const auto size_of = [&](const std::string& options) {
    const CommandResult result =
        run_isostrata("render sphere:12 --interval 0.2:0.6,name=shell --size 200x150 --device surfaceless " + options +
                      " --json --out '" + (folder / "a.png").string() + "'");
    EXPECT_EQ(result.status, 0) << options << ": " << result.err;
    return read_text(folder / "a.png");
  };
  const std::string plain = size_of("");
  for (const char* options :
       {"--axes", "--box", "--legend", "--samples 2", "--clip 'x<0.1' --clip 'normal=0,1,1;offset=-0.2'",
        "--camera '+x;projection=orthographic'", "--background transparent --box --legend --axes --samples 3"})
    EXPECT_NE(size_of(options), plain) << options;
  EXPECT_EQ(size_of(""), plain);
}

TEST(RenderCommand, WrongUsageIsStatusTwo) {
  EXPECT_EQ(run_isostrata("render torus:8").status, 2);
  EXPECT_EQ(run_isostrata("render torus:8 --out a.png --mode upside-down").status, 2);
  EXPECT_EQ(run_isostrata("render torus:8 --out a.png --samples 17").status, 2);
}

TEST(BenchRenderCommand, ReportsWhatItMeasured) {
  const CommandResult result =
      run_isostrata("bench render --data torus:16 --size 96x64 --repeat 3 --device surfaceless --interval 0.1:0.3 --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto runs = boost::json::parse(result.out).at("runs").as_array();
  ASSERT_EQ(runs.size(), 2u);
  for (const auto& run : runs) {
    EXPECT_GT(run.at("tetrahedra").to_number<long>(), 1000);
    EXPECT_GT(run.at("fragments_per_tetrahedron").to_number<double>(), 0.5);
    EXPECT_GT(run.at("depth_complexity").to_number<double>(), 2);
    EXPECT_LE(run.at("ms").at("total").at("min").to_number<double>(), run.at("ms").at("total").at("median").to_number<double>());
    EXPECT_GT(run.at("tetrahedra_per_second").to_number<double>(), 0);
  }
}

}  // namespace
