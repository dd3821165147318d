// Small pictures of the files of a served folder, over real sockets: who gets them, when they change, what a bad file costs.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <boost/json/parse.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <thread>

#include "net/answers.h"
#include "net/running_server.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using std::chrono::milliseconds;

/// 16 x 16 x 16 distances from a point.
std::string field(double at) {
  std::string text = "NRRD0004\ntype: float\ndimension: 3\nsizes: 16 16 16\nencoding: raw\nendian: little\n\n";
  for (int k = 0; k < 16; ++k)
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 16; ++i) {
        const auto value = static_cast<float>(std::hypot(i - at, j - 8, k - 8));
        text.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
  return text;
}

class Thumbnails : public ::testing::Test {
 protected:
  void begin() {
    LivingOptions living;
    living.watch.quiet = milliseconds(3000);
    ServerOptions options;
    options.living = std::make_shared<LivingCatalogue>(std::vector<std::string>{folder_.path().string()}, living);
    server_ = std::make_unique<RunningServer>(std::move(options));
    names();
  }
  void TearDown() override { server_.reset(); }

  void put(const std::string& name, const std::string& text) const {
    outside_.write("new", text);
    fs::rename(outside_ / "new", folder_ / name);
  }
  /// Those that are listed now, with what is said of them.
  std::map<std::string, json::value> names() {
    std::map<std::string, json::value> entries;
    const json::value listed = json::parse(text_of(server_->ask("GET", "/api/v1/datasets")));
    for (const json::value& entry : listed.at("datasets").as_array()) {
      const std::string name(entry.at("name").as_string());
      ids_[name] = std::string(entry.at("id").as_string());
      entries[name] = entry;
    }
    return entries;
  }
  bool in_time(const std::function<bool()>& holds) const {
    for (int i = 0; i < 400; ++i, std::this_thread::sleep_for(milliseconds(50)))
      if (holds()) return true;
    return false;
  }
  std::string path_of(const std::string& name) const { return "/api/v1/datasets/" + ids_.at(name) + "/thumbnail"; }
  std::string ask(const std::string& name, const std::string& headers = "") const { return server_->ask("GET", path_of(name), "", headers); }
  /// The picture's bytes.
  std::string picture(const std::string& name) const {
    const std::string response = ask(name);
    EXPECT_EQ(status_of(response), 200) << name << ": " << response.substr(0, 600);
    EXPECT_EQ(header_of(response, "Content-Type"), "image/png");
    const std::string body = text_of(response);
    EXPECT_TRUE(body.starts_with("\x89PNG\r\n\x1a\n")) << name;
    EXPECT_GT(body.size(), 1000u) << name << ": a picture of one colour is smaller";
    return body;
  }

  testing::TemporaryFolder folder_, outside_;
  std::unique_ptr<RunningServer> server_;
  std::map<std::string, std::string> ids_;
};

TEST_F(Thumbnails, DifferBetweenFilesAndAreTheSameAgain) {
  put("a.nrrd", field(3));
  put("b.nrrd", field(12));
  begin();
  const std::string a = picture("a.nrrd");
  EXPECT_NE(a, picture("b.nrrd"));
  EXPECT_EQ(a, picture("a.nrrd"));
  const std::string tag = header_of(ask("a.nrrd"), "ETag");
  EXPECT_EQ(status_of(ask("a.nrrd", "If-None-Match: " + tag + "\r\n")), 304);
  EXPECT_EQ(status_of(ask("b.nrrd", "If-None-Match: " + tag + "\r\n")), 200);
  EXPECT_EQ(status_of(server_->ask("GET", "/api/v1/datasets/nothing/thumbnail")), 404);
}

TEST_F(Thumbnails, OfAFileThatIsRewrittenAreOthers) {
  put("a.nrrd", field(3));
  begin();
  const std::string before = picture("a.nrrd"), tag = header_of(ask("a.nrrd"), "ETag");
  put("a.nrrd", field(12));
  ASSERT_TRUE(in_time([&] { return names().at("a.nrrd").at("news").as_string() == "DATASET_NEWS_CHANGED"; }));
  EXPECT_NE(picture("a.nrrd"), before);
  EXPECT_EQ(status_of(ask("a.nrrd", "If-None-Match: " + tag + "\r\n")), 200);
  put("a.nrrd", field(3));
  ASSERT_TRUE(in_time([&] { return header_of(ask("a.nrrd"), "ETag") == tag; })) << "what it shows is as before";
}

TEST_F(Thumbnails, ABrokenFileHasNoneSaysWhyAndCostsNobodyElse) {
  put("broken.nrrd", field(3).substr(0, 500));
  put("f\xc3\xbcr.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 nonsense\n");
  put("good.nrrd", field(12));
  begin();
  for (int i = 0; i < 3; ++i)
    for (const char* name : {"broken.nrrd", "f\xc3\xbcr.vtk"}) {
      const std::string response = ask(name);
      EXPECT_EQ(status_of(response), 204) << response;
      EXPECT_FALSE(header_of(response, "Isostrata-Reason").empty()) << response;
      EXPECT_EQ(header_of(response, "Isostrata-Reason").find(folder_.path().string()), std::string::npos);
    }
  EXPECT_NE(header_of(ask("f\xc3\xbcr.vtk"), "Isostrata-Reason").find("f%C3%BCr.vtk"), std::string::npos);
  picture("good.nrrd");
  put("broken.nrrd", field(3));
  ASSERT_TRUE(in_time([&] { return names().at("broken.nrrd").at("news").as_string() == "DATASET_NEWS_CHANGED"; }));
  picture("broken.nrrd");
  EXPECT_TRUE(server_->answers());
}

TEST_F(Thumbnails, AFileThatIsWrittenAndOneThatGivesNoBytesHoldUpNobody) {
  put("a.nrrd", field(3));
  put("b.nrrd", field(12));
  begin();
  fs::remove(folder_ / "a.nrrd");
  ASSERT_EQ(mkfifo((folder_ / "a.nrrd").c_str(), 0600), 0);  // whoever opens it waits
  const std::string response = ask("a.nrrd");
  EXPECT_TRUE(status_of(response) == 503 || status_of(response) == 404) << response;
  picture("b.nrrd");
  std::ofstream out(folder_ / "c.nrrd", std::ios::binary);
  out << field(5).substr(0, 400) << std::flush;
  ASSERT_TRUE(in_time([&] {
    const auto all = names();
    return all.contains("c.nrrd") && all.at("c.nrrd").as_object().contains("writing");
  }));
  EXPECT_EQ(status_of(ask("c.nrrd")), 503);
  picture("b.nrrd");
  out << field(5).substr(400) << std::flush;
  out.close();
  ASSERT_TRUE(in_time([&] { return status_of(ask("c.nrrd")) == 200; }));
  picture("c.nrrd");
}

TEST_F(Thumbnails, NeedATokenAndOneOfAnInvitationSuffices) {
  put("a.nrrd", field(3));
  begin();
  EXPECT_EQ(status_of(server_->raw("GET " + path_of("a.nrrd") + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")), 401);
  client::Client controller(server_->client_options());
  const std::string made = server_->ask("POST", "/api/v1/sessions/" + controller.welcome().session() + "/invitations",
                                        R"({"role":"ROLE_VIEWER","seconds":600,"name":"for a test"})");
  ASSERT_EQ(status_of(made), 201) << made;
  const std::string token(json::parse(text_of(made)).at("token").as_string());
  const auto as_guest = [&](const std::string& path) {
    return server_->raw("GET " + path + "?token=" + token + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  };
  EXPECT_EQ(status_of(as_guest(path_of("a.nrrd"))), 200);
  EXPECT_EQ(status_of(as_guest("/api/v1/datasets")), 403);
  EXPECT_EQ(status_of(as_guest("/api/v1/datasets/" + ids_.at("a.nrrd"))), 403);
  EXPECT_EQ(status_of(server_->ask("POST", path_of("a.nrrd"))), 405);
}

TEST_F(Thumbnails, WhoeverGoesLeavesNoWorkBehind) {
  for (char c = 'a'; c <= 'z'; ++c) put(std::string("file ") + c + ".nrrd", field(c - 'a'));
  put("last.nrrd", field(3));
  begin();
  ASSERT_EQ(ids_.size(), 27u);
  {
    std::vector<std::unique_ptr<RawSocket>> sockets;
    for (const auto& [name, id] : ids_) {
      sockets.push_back(std::make_unique<RawSocket>(server_->port()));
      sockets.back()->send("GET /api/v1/datasets/" + id + "/thumbnail HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " + RunningServer::kToken + "\r\n\r\n");
    }
  }
  picture("last.nrrd");
  EXPECT_TRUE(server_->answers());
}

}  // namespace
}  // namespace isostrata
