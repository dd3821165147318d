// The examples of client/examples, built against an installed package (build_examples.cmake), before a real server.
#include <gtest/gtest.h>

#include "isostrata/client.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

namespace fs = std::filesystem;

class Examples : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(ISOSTRATA_EXAMPLES_DIR))
      GTEST_SKIP() << "the examples are built by the test client_package, which a build with sanitizers has not";
    SERVED_OR_SKIP(server_);
  }
  Ended run(const std::string& name, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {std::string(ISOSTRATA_EXAMPLES_DIR) + "/" + name, server_.url()});
    return run_to_end(std::move(arguments));
  }
  client::Picture picture(const fs::path& path) const {
    const std::string bytes = read_text(path);
    EXPECT_FALSE(bytes.empty()) << path;
    return client::decode(bytes);
  }

  Served server_{{"torus:12", "cylinder:12x12x8x3"}};
  TemporaryFolder folder_;
};

TEST_F(Examples, ConnectTellsWhatTheServerOffers) {
  const Ended ended = run("01_connect", {});
  EXPECT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(ended.out.find("  torus:12\n  cylinder:12x12x8x3\n"), std::string::npos) << ended.out;
  const Ended wrong = run_to_end({std::string(ISOSTRATA_EXAMPLES_DIR) + "/01_connect", "http://127.0.0.1:1/"});
  EXPECT_EQ(wrong.status, 1);
  EXPECT_EQ(wrong.err.substr(0, 12), "connection: ") << wrong.err;
}

TEST_F(Examples, DataCountsTheValues) {
  const Ended ended = run("02_data", {"torus:12"});
  EXPECT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(ended.out.find("uniform grid of 1331 cells"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("##########"), std::string::npos) << ended.out;
  EXPECT_EQ(run("02_data", {"nosuch"}).err.substr(0, 11), "not_found: ");
}

TEST_F(Examples, IntervalsAreAPicture) {
  const Ended ended = run("03_intervals", {"torus:12", (folder_ / "a.png").string()});
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_EQ(picture(folder_ / "a.png").width, 640);
}

TEST_F(Examples, AStreamEndsWithTheExactPicture) {
  const Ended ended = run("04_stream", {"torus:12"});
  EXPECT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(ended.out.find("at rest: revision 22, 320 x 240 pixels"), std::string::npos) << ended.out;
}

TEST_F(Examples, AStreamIsVideoWhereItIsDecoded) {
  const Ended ended = run("11_video", {"torus:12"});
  EXPECT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(ended.out.find("pictures, the last as vp9-444\nat rest: 320 x 240 pixels\n"), std::string::npos) << ended.out;
}

TEST_F(Examples, LooksAreDifferentPictures) {
  const Ended ended = run("05_looks", {"torus:12", folder_.path().string()});
  ASSERT_EQ(ended.status, 0) << ended.err;
  std::vector<client::Picture> pictures;
  for (const char* name : {"surfaces.png", "transfer.jpg", "priorities.png", "cycled.png"}) {
    pictures.push_back(picture(folder_ / name));
    EXPECT_EQ(pictures.back().width, 480) << name;
    for (std::size_t i = 0; i + 1 < pictures.size(); ++i) EXPECT_NE(pictures[i].rgb, pictures.back().rgb) << name;
  }
}

TEST_F(Examples, CombinationsAreSmallerThanTheirLayer) {
  const Ended ended = run("06_combine", {"cylinder:12x12x8x3"});
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(ended.out.find("between the first two steps"), std::string::npos) << ended.out;
  const auto count = [&](const std::string& line) { return std::stol(ended.out.substr(ended.out.find(line) + 28)); };
  EXPECT_GT(count("and a range of another"), 0) << ended.out;
  EXPECT_GT(count("without that range"), 0) << ended.out;
  EXPECT_NE(count("and a range of another"), count("a layer")) << ended.out;
}

TEST_F(Examples, AnOrbitSeesEverySide) {
  const Ended ended = run("07_orbit", {"torus:12", folder_.path().string()});
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(picture(folder_ / "0.png").rgb, picture(folder_ / "2.png").rgb);
  EXPECT_TRUE(fs::exists(folder_ / "7.png"));
}

TEST_F(Examples, WorkTellsItsProgress) {
  const Ended ended = run("08_progress", {"cylinder:12x12x8x3"});
  EXPECT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(ended.out.find(" tetrahedra"), std::string::npos) << ended.out;
}

TEST_F(Examples, SharedSessionsAreMoved) {
  client::Client watcher({.url = server_.url(), .width = 64, .height = 48});
  watcher.open_dataset("torus:12");
  const std::uint64_t before = watcher.state().revision();
  const Ended ended = run("09_share", {watcher.welcome().session()});
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(run("09_share", {}).out.find(watcher.welcome().session()), std::string::npos);
  const auto frame = watcher.lossless_frame();
  EXPECT_GT(frame.revision(), before);
  EXPECT_EQ(watcher.state().revision(), frame.revision());
}

TEST_F(Examples, SavedStatesComeBackToTheLastPixel) {
  const Ended ended = run("10_save", {"torus:12", (folder_ / "state.json").string()});
  EXPECT_EQ(ended.status, 0) << ended.out << ended.err;
  EXPECT_NE(ended.out.find("intervals[0].lower is wrong"), std::string::npos) << ended.out;
  EXPECT_NE(read_text(folder_ / "state.json").find("\"torus-12\""), std::string::npos);
}

}  // namespace
}  // namespace isostrata::testing
