// isostrata-client's commands before a real server.
#include <gtest/gtest.h>

#include <utility>

#include "isostrata/client.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

namespace fs = std::filesystem;

class ClientCommand : public ::testing::Test {
 protected:
  void SetUp() override { SERVED_OR_SKIP(server_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  Served server_{{"torus:12", "torus:260"}};
  TemporaryFolder folder_;
};

TEST_F(ClientCommand, RecordsAnOrbitAsPicturesThatDiffer) {
  const Ended ended = server_.client({"record", "--dataset", "torus:12", "--camera", "+x", "--size", "64x48", "--frames", "4",
                                      "--elevation", "20", "--out", path("f-%02d.png")});
  ASSERT_EQ(ended.status, 0) << ended.err;
  EXPECT_NE(ended.err.find("4 frames of 64x48"), std::string::npos) << ended.err;
  std::vector<client::Picture> pictures;
  for (const char* name : {"f-00.png", "f-01.png", "f-02.png", "f-03.png"}) {
    pictures.push_back(client::decode(read_text(folder_ / name)));
    EXPECT_EQ(pictures.back().width, 64);
  }
  EXPECT_NE(pictures[0].rgb, pictures[1].rgb);
  EXPECT_FALSE(fs::exists(folder_ / "f-04.png"));
}

TEST_F(ClientCommand, RecordsAPathAsAFilmOfItsLength) {
  folder_.write("path.json",
                R"({"fps":8,"keyframes":[{"time":0,"camera":{"eye":[4,0,1]}},{"time":1,"camera":{"eye":[0,4,1]}}]})");
  const Ended ended = server_.client({"record", "--size", "64x48", "--path", path("path.json"), "--out", path("a.y4m")});
  ASSERT_EQ(ended.status, 0) << ended.err;
  const std::string film = read_text(folder_ / "a.y4m");
  const auto head = film.find('\n') + 1;
  EXPECT_NE(film.substr(0, head).find(" F8000:1000 "), std::string::npos);
  EXPECT_EQ(film.size(), head + 9 * (6 + 64 * 48 * 3)) << "both ends of a second at 8 frames per second";
}

TEST_F(ClientCommand, LeavesTheCameraOfAJoinedSessionAsItWas) {
  client::Client watcher({.url = server_.url(), .width = 64, .height = 48});
  watcher.open_dataset("torus:12");
  const std::string before = watcher.state().camera().SerializeAsString();
  const auto revision = watcher.state().revision();
  const Ended ended = server_.client(
      {"record", "--session", watcher.welcome().session(), "--size", "32x24", "--frames", "3", "--out", path("%d.png")});
  ASSERT_EQ(ended.status, 0) << ended.err;
  watcher.lossless_frame();
  EXPECT_GT(watcher.state().revision(), revision);
  EXPECT_EQ(watcher.state().camera().SerializeAsString(), before);
}

TEST_F(ClientCommand, CtrlCEndsARecordingAndLeavesNoFilm) {
  Process recording({Served::program("isostrata-client"), server_.url(), "record", "--dataset", "torus:260", "--size", "800x600",
                     "--out", path("a.webm")});
  for (int i = 0; i < 3000 && !fs::exists(folder_ / "a.webm.part") && !recording.ended(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  recording.signal(SIGINT);
  EXPECT_EQ(recording.wait(), 1) << recording.err();
  EXPECT_NE(recording.err().find("isostrata-client: stopped"), std::string::npos) << recording.err();
  EXPECT_TRUE(fs::is_empty(folder_.path()));
  EXPECT_EQ(server_.client({"info"}).status, 0) << "the server goes on";
}

TEST_F(ClientCommand, WatchTellsWhatOthersChange) {
  client::Client mover({.url = server_.url(), .width = 0});
  mover.open_dataset("torus:12");
  Process watching(
      {Served::program("isostrata-client"), server_.url(), "watch", "--session", mover.welcome().session(), "--size", "64x48"});
  ASSERT_TRUE(watching.says("lossless 64x48")) << watching.out() << watching.err();
  const auto id = mover.state().intervals(1).id();
  mover.move_interval(id, 0.125, 0.375);
  const std::string revision = std::to_string(mover.state().revision());
  EXPECT_TRUE(watching.says("state    " + revision + ": ")) << watching.out();
  EXPECT_TRUE(watching.says("-> 0.375")) << watching.out();
  EXPECT_TRUE(watching.says(": revision " + revision + ", lossless 64x48")) << watching.out();
  watching.signal(SIGINT);
  EXPECT_EQ(watching.wait(), 0) << watching.err();
}

TEST_F(ClientCommand, WatchAsJsonIsADocumentALine) {
  const Ended ended = server_.client({"watch", "--json", "--dataset", "torus:12", "--size", "64x48", "--frames", "1"});
  ASSERT_EQ(ended.status, 0) << ended.err;
  bool framed = false;
  for (std::size_t at = 0; at < ended.out.size();) {
    const auto end = ended.out.find('\n', at);
    ASSERT_NE(end, std::string::npos);
    const auto document = boost::json::parse(ended.out.substr(at, end - at));
    framed = framed || document.as_object().contains("frame");
    at = end + 1;
  }
  EXPECT_TRUE(framed) << ended.out;
}

TEST_F(ClientCommand, SetMovesAnIntervalAndKeepsStates) {
  client::Client watcher({.url = server_.url(), .width = 0});
  watcher.open_dataset("torus:12");
  const std::string session = watcher.welcome().session();
  const auto id = watcher.state().intervals(0).id();
  const int layers = watcher.state().intervals_size();
  const Ended ended =
      server_.client({"set", "--session", session, "--move", std::to_string(id) + "=0.125:0.25", "--save-state", path("s.json")});
  ASSERT_EQ(ended.status, 0) << ended.err;
  watcher.set_view("+x");  // an answer comes after what happened before
  EXPECT_EQ(watcher.interval_of(id).lower(), 0.125);
  EXPECT_NE(ended.out.find("session  " + session + " shows torus-12 at revision "), std::string::npos) << ended.out;
  watcher.set_intervals({});
  ASSERT_EQ(server_.client({"set", "--session", session, "--load-state", path("s.json")}).status, 0);
  watcher.set_view("+y");
  EXPECT_EQ(watcher.state().intervals_size(), layers);
  EXPECT_EQ(server_.client({"set", "--session", session, "--move", "first=0:1"}).status, 2);
  EXPECT_EQ(server_.client({"set", "--session", session, "--move", "999=0:1"}).status, 1);
  EXPECT_EQ(server_.client({"set", "--session", session, "--load-state", path("nosuch.json")}).status, 1);
}

TEST_F(ClientCommand, SetTakesTheTransferFunctionThatRenderTakes) {
  client::Client watcher({.url = server_.url()});
  watcher.open_dataset("torus:12");
  const std::string session = watcher.welcome().session();
  folder_.write("good.json", R"({"points":[{"value":0.1,"color":"#ff0000","opacity":0.25},
                                           {"value":0.5,"color":"#0000ff","opacity":0.5}]})");
  const Ended ended = server_.client({"set", "--session", session, "--transfer", path("good.json")});
  ASSERT_EQ(ended.status, 0) << ended.err;
  const auto shows = [&](const auto& wanted) {
    for (int i = 0; i < 200 && !wanted(); ++i) watcher.receive(std::chrono::milliseconds(50));
    return wanted();
  };
  ASSERT_TRUE(shows([&] { return watcher.state().intervals_size() == 1; }));
  EXPECT_EQ(watcher.state().intervals(0).transfer_function().points_size(), 2);
  EXPECT_EQ(watcher.state().intervals(0).upper(), 0.5);

  const std::uint32_t id = watcher.state().intervals(0).id();
  watcher.set_transfer_function(id, {client::transfer_point(0.2, "#00ff00", 1), client::transfer_point(0.3, "#ffffff", 0)});
  EXPECT_EQ(watcher.interval_of(id).lower(), 0.2);
  watcher.set_transfer_function(id, {});
  EXPECT_FALSE(watcher.interval_of(id).has_transfer_function());

  folder_.write("text.json",
                R"([{"value":0.1,"color":"#ff0000","opacity":"much"},{"value":0.5,"color":"#0000ff","opacity":0.5}])");
  const Ended refused = server_.client({"set", "--session", session, "--transfer", path("text.json")});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("text.json: point 0: unexpected 'opacity'"), std::string::npos) << refused.err;
  EXPECT_EQ(server_.client({"set", "--session", session, "--transfer", path("nosuch.json")}).status, 1);
}

TEST_F(ClientCommand, ExportsAreTheFilesThatExtractWrites) {
  for (const std::string name : {"a.vtu", "a.ply", "a.stl"}) {
    const Ended ended = server_.client({"export", "--dataset", "torus:12", "--interval", "0.1:0.3", "--out", path(name)});
    ASSERT_EQ(ended.status, 0) << ended.err;
    const Ended extract = run_to_end(
        {Served::program("isostrata"), "extract", "torus:12", "--interval", "0.1:0.3", "--out", path("extract-" + name)});
    ASSERT_EQ(extract.status, 0) << extract.err;
    EXPECT_EQ(read_text(folder_ / name), read_text(folder_ / ("extract-" + name))) << name;
  }
  const Ended part = server_.client(
      {"export", "--dataset", "torus:12", "--interval", "0.1:0.3", "--out", path("part.stl"), "--facets", "lower,domain"});
  ASSERT_EQ(part.status, 0) << part.err;
  EXPECT_LT(fs::file_size(folder_ / "part.stl"), fs::file_size(folder_ / "a.stl"));
  EXPECT_EQ(server_.client({"export", "--out", path("a.obj")}).status, 2);
  EXPECT_EQ(server_.client({"export", "--out", path("a.stl"), "--facets", "left"}).status, 2);
  EXPECT_EQ(server_.client({"export", "--dataset", "torus:12", "--out", "/no/such/folder/a.stl"}).status, 1);
}

TEST_F(ClientCommand, CtrlCEndsAnExportAndTheServersWork) {
  Process exporting({Served::program("isostrata-client"), server_.url(), "export", "--dataset", "torus:260", "--interval",
                     "0.05:1.2", "--out", path("a.vtu")});
  for (int i = 0; i < 3000 && !fs::exists(folder_ / "a.vtu.part") && !exporting.ended(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  exporting.signal(SIGINT);
  EXPECT_EQ(exporting.wait(), 1) << exporting.err();
  EXPECT_NE(exporting.err().find("stopped"), std::string::npos) << exporting.err();
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(ClientCommand, SnapshotsAreOfTheFormatThatTheNameSays) {
  ASSERT_EQ(server_.client({"snapshot", "--dataset", "torus:12", "--size", "40x30", "--out", path("a.jpg")}).status, 0);
  EXPECT_EQ(read_text(folder_ / "a.jpg").substr(0, 2), "\xff\xd8");
  const Ended out = server_.client({"snapshot", "--dataset", "torus:12", "--size", "40x30", "--out", "-"});
  EXPECT_EQ(out.status, 0) << out.err;
  EXPECT_EQ(client::decode(out.out).height, 30);
  const Ended unknown = server_.client({"snapshot", "--dataset", "torus:12", "--out", path("a.bmp")});
  EXPECT_EQ(unknown.status, 1);
  EXPECT_NE(unknown.err.find("bmp"), std::string::npos) << unknown.err;
}

TEST_F(ClientCommand, WrongUsageIsStatus2AndSaysWhy) {
  folder_.write("bad.json", R"({"keyframes":[{"time":0,"camera":{"eye":[1,2]}}]})");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"record"}, "--out is required"},
      {{"record", "--out", path("a.gif")}, "expected a name that ends in .png, .y4m or .webm"},
      {{"record", "--out", path("a.png")}, "frame-%04d.png"},
      {{"record", "--out", path("a.y4m"), "--path", path("bad.json")}, "bad.json: keyframes[0].camera.eye"},
      {{"record", "--out", path("a.y4m"), "--frames", "0"}, "--frames"},
      {{"snapshot", "--out", path("a")}, "--format"},
      {{"watch", "--frames", "3"}, "--size"},
  };
  for (const auto& [arguments, part] : cases) {
    const Ended ended = server_.client(arguments);
    EXPECT_EQ(ended.status, 2) << part << ": " << ended.err;
    EXPECT_NE(ended.err.find(part), std::string::npos) << ended.err;
  }
  EXPECT_EQ(server_.client({"record", "--out", path("a.y4m"), "--path", path("nosuch.json")}).status, 1);
}

}  // namespace
}  // namespace isostrata::testing
