// A folder that changes while a real server offers it: what sessions, REST and the list are told.
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <chrono>
#include <fstream>

#include "net/running_server.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// 4 x 4 x 4 numbers from `first` on.
std::string field(float first) {
  std::string text = "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nendian: little\n\n";
  for (int i = 0; i < 64; ++i) {
    const float value = first + static_cast<float>(i);
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return text;
}

class ServedFolder : public ::testing::TestWithParam<bool> {
 protected:
  void begin() {
    LivingOptions living;
    living.watch.inotify = GetParam();
    living.watch.quiet = milliseconds(3000);  // longer than a busy machine takes to answer
    ServerOptions options;
    options.living = std::make_shared<LivingCatalogue>(std::vector<std::string>{folder_.path().string()}, living);
    server_ = std::make_unique<RunningServer>(std::move(options));
  }
  void TearDown() override { server_.reset(); }

  void put(const std::string& name, const std::string& text) {
    outside_.write("new", text);
    fs::create_directories((folder_ / name).parent_path());
    fs::rename(outside_ / "new", folder_ / name);
  }
  json::value get(const std::string& path) {
    const std::string response = server_->ask("GET", "/api/v1" + path);
    EXPECT_EQ(status_of(response), 200) << response;
    return json::parse(response.substr(response.find("\r\n\r\n") + 4));
  }
  /// Reads the client's messages until one is like that; an empty one where none is.
  template <class Law>
  static v1::ServerMessage wait_for(client::Client& client, const Law& law) {
    for (const auto end = Clock::now() + std::chrono::seconds(20); Clock::now() < end;) {
      const auto message = client.receive(milliseconds(200));
      if (message && law(*message)) return *message;
    }
    ADD_FAILURE() << "the message did not come";
    return {};
  }
  template <class Law>
  static v1::DatasetInfo wait_for_info(client::Client& client, const Law& law) {
    if (law(client.dataset())) return client.dataset();
    return wait_for(client, [&](const v1::ServerMessage& m) { return m.has_dataset_info() && law(m.dataset_info()); }).dataset_info();
  }

  testing::TemporaryFolder folder_, outside_;
  std::unique_ptr<RunningServer> server_;
};

INSTANTIATE_TEST_SUITE_P(Ways, ServedFolder, ::testing::Bool(), [](const auto& info) { return info.param ? "inotify" : "polling"; });

TEST_P(ServedFolder, TheListSaysWhatCameAndItsTagIsAnotherThen) {
  put("a.nrrd", field(0));
  begin();
  client::Client client(server_->client_options());
  const std::string before = server_->ask("GET", "/api/v1/datasets");
  const auto tag = [](const std::string& response) {
    const auto at = response.find("ETag: ");
    return at == std::string::npos ? std::string() : response.substr(at + 6, response.find("\r\n", at) - at - 6);
  };
  EXPECT_EQ(status_of(server_->ask("GET", "/api/v1/datasets", "", "If-None-Match: " + tag(before) + "\r\n")), 304);
  put("deep/late.nrrd", field(1));
  const auto told = wait_for(client, [](const v1::ServerMessage& m) {
    return m.has_datasets_changed() && m.datasets_changed().entries_size() > 0 && m.datasets_changed().entries(0).name() == "deep/late.nrrd";
  });
  EXPECT_EQ(told.datasets_changed().entries(0).news(), v1::DATASET_NEWS_APPEARED);
  EXPECT_EQ(told.datasets_changed().all(), 2u);
  EXPECT_EQ(status_of(server_->ask("GET", "/api/v1/datasets", "", "If-None-Match: " + tag(before) + "\r\n")), 200);
  const json::value all = get("/datasets");
  ASSERT_EQ(all.at("datasets").as_array().size(), 2u);
  EXPECT_EQ(all.at("datasets").at(0).at("kind").as_string(), "NRRD");
  const json::value top = get("/datasets?folder=");
  EXPECT_EQ(top.at("folders").at(0).at("name").as_string(), "deep");
  EXPECT_EQ(top.at("datasets").as_array().size(), 1u);
  EXPECT_EQ(get("/datasets?search=LATE").at("datasets").at(0).at("name").as_string(), "deep/late.nrrd");
  EXPECT_EQ(get("/datasets?folder=deep&first=1").at("datasets").as_array().size(), 0u);
}

TEST_P(ServedFolder, ASessionGainsTheStepsOfASeriesAndNothingElseChanges) {
  for (const int n : {1, 2}) put("run_" + std::to_string(n) + ".nrrd", field(static_cast<float>(n)));
  begin();
  client::Client client(server_->client_options());
  wait_for_info(client, [](const auto& info) { return info.times_size() == 2 && info.missing_range_steps() == 0; });
  client.set_view("+x");  // answered by the state, which comes after what is said of the dataset
  const v1::State before = client.state();
  put("run_3.nrrd", field(500));
  const auto grown = wait_for_info(client, [](const auto& info) { return info.times_size() == 3 && info.missing_range_steps() == 0; });
  EXPECT_EQ(grown.times(2), 3);
  EXPECT_EQ(grown.on_disk(), v1::ON_DISK_UNSPECIFIED);
  EXPECT_EQ(grown.arrays(0).upper(), 563);
  EXPECT_EQ(client.state().intervals_size(), before.intervals_size());
  EXPECT_EQ(client.state().step(), before.step());
  client.set_step(2);
  EXPECT_EQ(client.lossless_frame().step(), 2);
}

TEST_P(ServedFolder, ABoxOfASeriesGainsItsStepsAsTheWholeDoes) {
  for (const int n : {1, 2}) put("run_" + std::to_string(n) + ".nrrd", field(static_cast<float>(n)));
  begin();
  client::Client client(server_->client_options());
  const std::string whole = wait_for_info(client, [](const auto& info) { return info.times_size() == 2; }).id();
  client.open_dataset(whole, "0:1,:,:");
  wait_for_info(client, [](const auto& info) { return info.points() == 32 && info.missing_range_steps() == 0; });
  for (const int n : {3, 4}) {
    put("run_" + std::to_string(n) + ".nrrd", field(static_cast<float>(100 * n)));
    const auto grown = wait_for_info(client, [&](const auto& info) { return info.times_size() == n && info.missing_range_steps() == 0; });
    EXPECT_EQ(grown.points(), 32);
    EXPECT_EQ(grown.arrays(0).upper(), 100 * n + 61) << "the last value of the box";
  }
  client.set_step(3);
  EXPECT_EQ(client.lossless_frame().step(), 3);
  client::Client other(server_->client_options());
  other.open_dataset(whole);
  wait_for_info(other, [](const auto& info) { return info.times_size() == 4 && info.points() == 64; });
}

TEST_P(ServedFolder, ARewrittenFileIsShownWhenSomebodyAsksAndTheLayersStay) {
  put("a.nrrd", field(0));
  begin();
  client::Client client(server_->client_options());
  wait_for_info(client, [](const auto& info) { return info.arrays_size() == 1; });
  v1::Interval layer;
  layer.set_lower(10);
  layer.set_upper(20);
  layer.mutable_color()->set_g(1);
  layer.set_opacity(0.5);
  layer.set_visible(true);
  client.set_intervals({layer});
  client.set_view("+x");
  put("a.nrrd", field(5));
  const auto changed = wait_for_info(client, [](const auto& info) { return info.on_disk() == v1::ON_DISK_CHANGED; });
  EXPECT_EQ(changed.arrays(0).upper(), 63);  // what was read
  EXPECT_EQ(client.histogram(client.dataset().arrays(0).name(), 4).upper(), 63);
  const v1::State before = client.state();
  v1::ClientMessage reload;
  reload.mutable_reload_dataset();
  client.send(reload);
  const auto now = wait_for_info(client, [](const auto& info) { return info.on_disk() == v1::ON_DISK_UNSPECIFIED; });
  EXPECT_EQ(now.arrays(0).upper(), 68);
  wait_for(client, [&](const v1::ServerMessage& m) { return m.has_state() && m.state().revision() > before.revision(); });
  v1::State after = client.state();
  after.set_revision(before.revision());
  EXPECT_EQ(after.SerializeAsString(), before.SerializeAsString());
  EXPECT_EQ(client.histogram(client.dataset().arrays(0).name(), 4).upper(), 68);
  EXPECT_EQ(get("/datasets/" + now.id()).at("arrays").at(0).at("upper").to_number<double>(), 68);
}

TEST_P(ServedFolder, ADeletedFileStaysShownFromMemory) {
  put("a.nrrd", field(0));
  begin();
  client::Client client(server_->client_options());
  wait_for_info(client, [](const auto& info) { return info.arrays_size() == 1; });
  fs::remove(folder_ / "a.nrrd");
  wait_for_info(client, [](const auto& info) { return info.on_disk() == v1::ON_DISK_GONE; });
  v1::Interval layer = client.state().intervals(0);
  client.move_interval(layer.id(), 3, 4);
  EXPECT_GT(client.lossless_frame().facts().tetrahedra(), 0);
  EXPECT_EQ(get("/datasets").at("datasets").at(0).at("news").as_string(), "DATASET_NEWS_GONE");
}

TEST_P(ServedFolder, AFileThatIsStillBeingWrittenIsWaitedForAndThenOpened) {
  put("a.nrrd", field(0));
  begin();
  client::Client client(server_->client_options());
  wait_for_info(client, [](const auto& info) { return info.arrays_size() == 1; });
  const std::string whole = field(7);
  std::ofstream out(folder_ / "b.nrrd", std::ios::binary);
  out << whole.substr(0, 150) << std::flush;
  const auto told = wait_for(client, [](const v1::ServerMessage& m) {
    return m.has_datasets_changed() && m.datasets_changed().entries_size() > 0 && m.datasets_changed().entries(0).writing();
  });
  v1::ClientMessage open;
  open.mutable_open_dataset()->set_id(told.datasets_changed().entries(0).id());
  client.send(open);
  const auto waits = wait_for(client, [](const v1::ServerMessage& m) { return m.has_progress() && m.progress().stage().find("is being written") != std::string::npos; });
  EXPECT_NE(waits.progress().operation(), 0u);
  out << whole.substr(150) << std::flush;
  out.close();
  const auto info = wait_for_info(client, [](const auto& info) { return info.name() == "b.nrrd"; });
  ASSERT_EQ(info.arrays_size(), 1);
  EXPECT_EQ(info.arrays(0).upper(), 70);
}

}  // namespace
}  // namespace isostrata
