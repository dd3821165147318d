// The real programs, end to end: isostrata serve, isostrata-client, a kill and a new start.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "net/raw_socket.h"
#include "support/kept.h"
#include "support/places.h"
#include "support/temporary_folder.h"

extern char** environ;

namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using namespace std::chrono_literals;
using isostrata::testing::read_text;

class ServeCommand : public ::testing::Test {
 protected:
  ServeCommand() { setenv("XDG_STATE_HOME", directory_.path().c_str(), 1); }
  ~ServeCommand() override {
    if (server_ > 0) {
      kill(server_, SIGKILL);
      waitpid(server_, nullptr, 0);
    }
  }

  pid_t start(const std::string& program, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), isostrata::places::binaries() + "/" + program);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 1, out().c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&files, 2, errors().c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    pid_t pid = -1;
    EXPECT_EQ(posix_spawn(&pid, argv[0], &files, nullptr, argv.data(), environ), 0) << argv[0];
    posix_spawn_file_actions_destroy(&files);
    return pid;
  }
  static int end_of(pid_t pid) {
    int status = 0;
    if (pid <= 0) return -1;  // nothing was started: to wait for -1 is to wait for every child, and to kill it is to kill every process
    for (int i = 0; i < 3000; ++i) {
      if (waitpid(pid, &status, WNOHANG) == pid) return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      std::this_thread::sleep_for(10ms);
    }
    kill(pid, SIGKILL);
    waitpid(pid, &status, 0);
    return -1;
  }
  int run(const std::string& program, std::vector<std::string> arguments) { return end_of(start(program, std::move(arguments))); }

  /// Starts a server and reads its ready file; false if no device on this machine can draw.
  bool serve(std::vector<std::string> arguments, const std::string& port = "0") {
    fs::remove(ready());
    arguments.insert(arguments.begin(), "serve");
    arguments.insert(arguments.end(), {"--port", port, "--ready-file", ready().string()});
    server_ = start("isostrata", std::move(arguments));
    for (int i = 0; i < 2000 && !fs::exists(ready()); ++i) {
      int status = 0;
      if (waitpid(server_, &status, WNOHANG) == server_) {
        server_ = -1;
        return false;
      }
      std::this_thread::sleep_for(10ms);
    }
    ready_ = json::parse(read_text(ready()));
    url_ = std::string(ready_.at("url").as_string());
    return true;
  }
  int stop(int signal) {
    if (server_ <= 0) return -1;  // a signal to -1 would be one to every process
    kill(server_, signal);
    const int status = end_of(server_);
    server_ = -1;
    return status;
  }

  fs::path ready() const { return directory_ / "ready.json"; }
  fs::path out() const { return directory_ / "out.txt"; }
  fs::path errors() const { return directory_ / "errors.txt"; }

  isostrata::testing::TemporaryFolder directory_;
  pid_t server_ = -1;
  json::value ready_;
  std::string url_;
};

#define SERVE_OR_SKIP(...) \
  if (!serve(__VA_ARGS__)) GTEST_SKIP() << "isostrata serve does not start here: " << read_text(errors())

TEST_F(ServeCommand, AnnouncesItselfOnceItAnswersAndEndsWhenAsked) {
  SERVE_OR_SKIP({"torus:12"});
  EXPECT_EQ(ready_.at("pid").to_number<int>(), server_);
  EXPECT_FALSE(ready_.at("device").as_string().empty());
  const std::string port = std::to_string(ready_.at("port").to_number<int>());
  EXPECT_NE(url_.find("http://127.0.0.1:" + port + "/?token="), std::string::npos) << url_;
  EXPECT_GE(url_.size() - url_.find('=') - 1, 48u) << "at least 192 bits of token";
  EXPECT_EQ(fs::status(ready()).permissions() & fs::perms::others_read, fs::perms::none);
  const std::string printed = read_text(out());
  EXPECT_NE(printed.find(url_), std::string::npos) << printed;
  EXPECT_NE(printed.find("ssh -L " + port + ":127.0.0.1:" + port), std::string::npos) << printed;
  EXPECT_EQ(read_text(errors()).find(url_.substr(url_.find('=') + 1)), std::string::npos) << "the token is in the log";
  const fs::path log = errors();
  EXPECT_EQ(stop(SIGTERM), 0) << read_text(log);
  EXPECT_FALSE(fs::exists(ready()));
}

TEST_F(ServeCommand, ReadsOptionsFromAFileAndTheCommandLineComesFirst) {
  const auto options = directory_.write("options.toml", "# a comment\nno-auth = true\nmax-sessions = 3\nlog-format = \"json\"\n");
  SERVE_OR_SKIP({"torus:12", "--config", options.string(), "--log-format", "text"});
  EXPECT_EQ(url_.find("token="), std::string::npos) << url_;
  EXPECT_EQ(read_text(errors()).find('{'), std::string::npos) << read_text(errors());
}

TEST_F(ServeCommand, AFileWithAWrongOptionIsAUsageErrorThatNamesIt) {
  for (const auto& [text, part] : {std::pair{"prot = 8080\n", "no option 'prot'"}, std::pair{"port = 99999\n", "port: "},
                                   std::pair{"[serve]\nport = 0\n", "no option 'serve.port'"}}) {
    const auto options = directory_.write("wrong.toml", text);
    EXPECT_EQ(run("isostrata", {"serve", "torus:12", "--config", options.string()}), 2) << text;
    const std::string printed = read_text(errors());
    EXPECT_NE(printed.find("wrong.toml"), std::string::npos) << printed;
    EXPECT_NE(printed.find(part), std::string::npos) << printed;
  }
  EXPECT_EQ(run("isostrata", {"serve", "--config", (directory_ / "absent.toml").string()}), 2);
}

TEST_F(ServeCommand, TheClientTakesAPictureAndMeasures) {
  SERVE_OR_SKIP({"torus:12", "tets:6"});
  ASSERT_EQ(run("isostrata-client", {url_, "info", "--json"}), 0) << read_text(errors());
  const auto welcome = json::parse(read_text(out()));
  EXPECT_EQ(welcome.at("datasets").as_array().size(), 2u);

  const std::string picture = (directory_ / "a.png").string();
  ASSERT_EQ(run("isostrata-client", {url_, "snapshot", "--dataset", "tets-6", "--interval", "0.2:0.5,color=#ff0000,opacity=0.9",
                                     "--size", "120x90", "--camera", "+x", "--out", picture}),
            0)
      << read_text(errors());
  EXPECT_TRUE(read_text(picture).starts_with("\x89PNG"));

  ASSERT_EQ(run("isostrata-client", {url_, "latency", "--seconds", "1", "--size", "120x90", "--dataset", "torus-12", "--interval",
                                     "0.2:0.4", "--json"}),
            0)
      << read_text(errors());
  const auto measured = json::parse(read_text(out()));
  EXPECT_GT(measured.at("fps").to_number<double>(), 0);
  EXPECT_GT(measured.at("bytes_per_frame").to_number<double>(), 0);
  const auto& latency = measured.at("input_to_decoded_ms");
  EXPECT_LE(latency.at("p50").to_number<double>(), latency.at("p95").to_number<double>());
  EXPECT_LE(latency.at("p95").to_number<double>(), latency.at("max").to_number<double>());
}

// The module that reads pictures lies beside the programs, which a reader that is shut in finds as well as any other.
TEST_F(ServeCommand, PicturesAreReadByAServerThatIsShutIn) {
  std::string picture = "P5 32 24 255\n";
  for (int i = 0; i < 32 * 24; ++i) picture.push_back(static_cast<char>(i % 32 * 8));
  for (const char* name : {"pictures/slice_1.pgm", "pictures/slice_2.pgm", "pictures/slice_3.pgm"}) directory_.write(name, picture);
  SERVE_OR_SKIP({(directory_ / "pictures").string(), "--state-dir", "none"});
  ASSERT_EQ(run("isostrata-client", {url_, "info", "--json"}), 0) << read_text(errors());
  const std::string id(json::parse(read_text(out())).at("datasets").at(0).at("id").as_string());
  EXPECT_EQ(run("isostrata-client", {url_, "snapshot", "--dataset", id, "--interval", "50:200", "--size", "64x48", "--out", (directory_ / "a.png").string()}), 0) << read_text(errors());
}

TEST_F(ServeCommand, TwoPicturesOfOneStateAreTheSameBytes) {
  SERVE_OR_SKIP({"torus:12"});
  std::vector<std::string> pictures;
  for (const char* name : {"one.png", "two.png"}) {
    const std::string path = (directory_ / name).string();
    ASSERT_EQ(run("isostrata-client", {url_, "snapshot", "--interval", "0.2:0.3", "--size", "160x120", "--out", path}), 0)
        << read_text(errors());
    pictures.push_back(read_text(path));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  const std::string other = (directory_ / "three.png").string();
  ASSERT_EQ(run("isostrata-client", {url_, "snapshot", "--interval", "0.2:0.5", "--size", "160x120", "--out", other}), 0);
  EXPECT_NE(read_text(other), pictures[0]) << "the picture does not show the interval";
}

TEST_F(ServeCommand, AKilledServerIsReplacedOnTheSamePortWithTheSameToken) {
  const std::string token = "the-same-token-in-every-life";
  SERVE_OR_SKIP({"torus:12", "--token", token});
  const std::string port = std::to_string(ready_.at("port").to_number<int>());
  const std::string url = url_;
  ASSERT_EQ(run("isostrata-client", {url, "info", "--json"}), 0);
  const std::string old = std::string(json::parse(read_text(out())).at("resumeToken").as_string());
  isostrata::testing::wait_until_kept(directory_.path(), "ISOR");  // a whole record
  EXPECT_EQ(stop(SIGKILL), 128 + SIGKILL);
  EXPECT_EQ(run("isostrata-client", {url, "info"}), 1) << "nobody is there";
  ASSERT_TRUE(serve({"torus:12", "--token", token}, port));
  EXPECT_EQ(url_, url);
  EXPECT_EQ(run("isostrata-client", {url, "info"}), 0) << read_text(errors());
  EXPECT_EQ(run("isostrata-client", {url, "info", "--session", old}), 0) << "the session was kept: " << read_text(errors());
  EXPECT_EQ(stop(SIGKILL), 128 + SIGKILL);
  ASSERT_TRUE(serve({"torus:12", "--token", token, "--state-dir", "none"}, port));
  EXPECT_EQ(run("isostrata-client", {url, "info", "--session", old}), 1) << "nothing was kept, and that is said";
}

/// Whether a process runs: neither gone nor waiting to be waited for.
bool runs(pid_t pid) {
  const std::string stat = read_text("/proc/" + std::to_string(pid) + "/stat");
  const auto name_end = stat.rfind(") ");
  return name_end != std::string::npos && stat[name_end + 2] != 'Z' && stat[name_end + 2] != 'X';
}
bool soon_gone(pid_t pid) {
  for (int i = 0; i < 3000 && runs(pid); ++i) std::this_thread::sleep_for(10ms);
  return !runs(pid);
}

/// One request of the API on a connection of its own.
class Asked {
 public:
  Asked(unsigned short port, const std::string& token, const std::string& method, const std::string& path, const std::string& body = "")
      : socket_(port) {
    socket_.send(method + " /api/v1/" + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer " + token +
                 "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  }
  /// The answer's body; null if the status is another one.
  json::value answer(int status) {
    const std::string all = socket_.read_all(nullptr, 20000);
    if (all.find(" " + std::to_string(status) + " ") != 8) {
      ADD_FAILURE() << all;
      return nullptr;
    }
    const std::string body = all.substr(all.find("\r\n\r\n") + 4);
    return body.empty() ? json::value() : json::parse(body);
  }

 private:
  isostrata::RawSocket socket_;
};

TEST_F(ServeCommand, WhatWasAnsweredSurvivesAKillAtThatMoment) {
  const std::string token = "the-same-token-in-every-life";
  SERVE_OR_SKIP({"torus:12", "--token", token});
  auto port = static_cast<unsigned short>(ready_.at("port").to_number<int>());
  constexpr int kSessions = 16;
  std::vector<std::string> sessions;
  for (int i = 0; i < kSessions; ++i)
    sessions.emplace_back(
        Asked(port, token, "POST", "sessions", R"({"dataset": "torus-12"})").answer(201).at("id").as_string());
  const auto first = [&](const std::string& session) {
    return Asked(port, token, "GET", "sessions/" + session + "/intervals").answer(200).at("intervals").at(0);
  };
  for (int life = 1; life <= 3; ++life) {
    std::vector<std::unique_ptr<Asked>> changes;
    std::vector<std::string> paths;
    for (const std::string& session : sessions)
      paths.push_back("sessions/" + session + "/intervals/" + json::serialize(first(session).at("id")));
    const std::string change = R"({"lower": 0.1, "upper": )" + std::to_string(0.2 + 0.1 * life) + "}";
    for (const std::string& path : paths) changes.push_back(std::make_unique<Asked>(port, token, "PATCH", path, change));
    for (auto& asked : changes) asked->answer(200);
    stop(SIGKILL);
    ASSERT_TRUE(serve({"torus:12", "--token", token}, std::to_string(port)));
    for (const std::string& session : sessions)
      EXPECT_NEAR(first(session).at("upper").to_number<double>(), 0.2 + 0.1 * life, 1e-9) << "after kill " << life;
  }
}

// It was asked for again and again, by a request that was never answered and a server that never ended.
TEST_F(ServeCommand, ASessionWhoseDatasetIsServedNoMoreIsAnsweredFor) {
  const std::string token = "the-same-token-in-every-life";
  SERVE_OR_SKIP({"torus:12", "--token", token});
  const auto port = static_cast<unsigned short>(ready_.at("port").to_number<int>());
  const std::string session(Asked(port, token, "POST", "sessions", R"({"dataset": "torus-12"})").answer(201).at("id").as_string());
  stop(SIGKILL);
  ASSERT_TRUE(serve({"sphere:12", "--token", token}, std::to_string(port)));
  EXPECT_EQ(Asked(port, token, "GET", "sessions/" + session + "/state").answer(200).at("dataset"), "torus-12");
  EXPECT_EQ(stop(SIGTERM), 0);
}

TEST_F(ServeCommand, ASavedSessionIsRenderedAsItsPageShowsIt) {
  const std::string token = "the-same-token-in-every-life";
  SERVE_OR_SKIP({"cylinder:16x12x8x3", "--token", token, "--device", "native"});
  const auto port = static_cast<unsigned short>(ready_.at("port").to_number<int>());
  const auto datasets = Asked(port, token, "GET", "datasets").answer(200);
  const std::string dataset(datasets.at("datasets").at(0).at("id").as_string());
  const std::string session(
      Asked(port, token, "POST", "sessions", R"({"dataset": ")" + dataset + "\"}").answer(201).at("id").as_string());
  const std::string path = "sessions/" + session;
  const auto interval = [&](int i) { return Asked(port, token, "GET", path + "/intervals").answer(200).at("intervals").at(i); };
  const auto patch = [&](const std::string& what, const std::string& body) { Asked(port, token, "PATCH", path + what, body).answer(200); };
  patch("/intervals/" + json::serialize(interval(0).at("id")), R"({"lower": "-inf", "colorMap": "viridis", "ownRange": true})");
  patch("/intervals/" + json::serialize(interval(1).at("id")),
        R"({"name": "wake", "surface": {"upper": true, "opacity": 0.4, "silhouette": 0.5}, "opacityUpper": 0.9})");
  patch("/state", R"({"step": 1, "clipPlanes": [{"normal": {"z": -1}, "offset": -3}], "annotations": {"axes": true, "legend": true}})");
  Asked(port, token, "PUT", path + "/view", R"({"view": "+y"})").answer(200);
  const auto picture = [&] {
    isostrata::RawSocket socket(port);
    socket.send("GET /api/v1/" + path + "/image?width=200&height=150 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" +
                "Authorization: Bearer " + token + "\r\n\r\n");
    const std::string all = socket.read_all(nullptr, 30000);
    return all.substr(all.find("\r\n\r\n") + 4);
  };
  const auto saved = directory_.write("saved.json", json::serialize(Asked(port, token, "GET", path + "/state").answer(200)));
  const std::string out = (directory_ / "state.png").string();
  const auto render = [&](std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"render", "cylinder:16x12x8x3", "--state", saved.string(), "--size", "200x150", "--renderer", "native",
                                       "--out",  out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(run("isostrata", arguments), 0) << read_text(errors());
    return read_text(out);
  };
  const std::string shown = picture();
  ASSERT_TRUE(shown.starts_with("\x89PNG"));
  EXPECT_EQ(render(), shown) << "byte for byte";

  // What the command line says comes first, and the rest stays.
  patch("/appearance", R"({"background": {"r": 1, "g": 0.5, "b": 0}})");
  Asked(port, token, "PUT", path + "/annotations", "{}").answer(200);
  Asked(port, token, "PUT", path + "/view", R"({"view": "-x"})").answer(200);
  const std::string other = picture();
  EXPECT_NE(other, shown);
  EXPECT_NE(render({"--background", "#ff8000"}), shown);

  // Modes go along: a cycle is the picture of its phase.
  patch("/state", R"({"mode": "RENDER_MODE_CYCLED", "cycle": {"seconds": 1, "phase": 1}})");
  directory_.write("saved.json", json::serialize(Asked(port, token, "GET", path + "/state").answer(200)));
  EXPECT_EQ(render(), picture());
  patch("/state", R"({"mode": "RENDER_MODE_SMEAR", "smear": {"steps": [0, 2]}})");
  directory_.write("saved.json", json::serialize(Asked(port, token, "GET", path + "/state").answer(200)));
  EXPECT_EQ(render(), picture());

  for (const char* wrong : {"", "{", "[]", R"({"intervals": 3})", R"({"array": "nosuch"})", R"({"intervals": [{"lower": 2, "upper": 1}]})"}) {
    directory_.write("saved.json", wrong);
    EXPECT_EQ(run("isostrata", {"render", "cylinder:16x12x8x3", "--state", saved.string(), "--out", out}), 1) << wrong;
    EXPECT_NE(read_text(errors()).find("saved.json"), std::string::npos) << read_text(errors());
  }
}

TEST_F(ServeCommand, WhereNothingCanBeDrawnReadyzAndPicturesSaySoUntilItCanBeAgain) {
  const fs::path place = directory_ / "temporary";
  fs::create_directory(place);
  setenv("TMPDIR", place.c_str(), 1);
  struct Restore {
    ~Restore() { unsetenv("TMPDIR"); }
  } restore;
  const std::string token = "the-same-token-in-every-life";
  SERVE_OR_SKIP({"torus:12", "--token", token});
  const auto port = static_cast<unsigned short>(ready_.at("port").to_number<int>());
  const auto status = [&](const std::string& path, const std::string& method = "GET") {
    isostrata::RawSocket socket(port);
    socket.send(method + " " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer " + token + "\r\n\r\n");
    return socket.read_all(nullptr, 30000);
  };
  const std::string session(
      Asked(port, token, "POST", "sessions", R"({"dataset": "torus-12"})").answer(201).at("id").as_string());
  const std::string image = "/api/v1/sessions/" + session + "/image?width=64&height=48";
  const auto kill_worker = [&] {
    for (int i = 0; i < 500; ++i) {
      const auto worker = Asked(port, token, "GET", "engine").answer(200).at("process").to_number<pid_t>();
      if (worker > 0) return void(kill(worker, SIGKILL));
      std::this_thread::sleep_for(10ms);
    }
  };
  ASSERT_EQ(status(image).find(" 200 "), 8u);

  // The place is gone, as after a cleaner of temporary files: it is made again.
  fs::remove_all(place);
  kill_worker();
  EXPECT_EQ(status(image).find(" 200 "), 8u) << status(image);
  EXPECT_TRUE(fs::exists(place));

  // It cannot be: a file has its name.
  fs::remove_all(place);
  std::ofstream(place) << "in the way";
  kill_worker();
  std::string ready;
  for (int i = 0; i < 1000 && ready.find(" 503 ") == std::string::npos; ++i, std::this_thread::sleep_for(20ms)) ready = status("/readyz");
  EXPECT_EQ(ready.find(" 503 "), 8u) << ready;
  EXPECT_NE(ready.find("temporary directory"), std::string::npos) << ready;
  const std::string refused = status(image);
  EXPECT_EQ(refused.find(" 503 "), 8u) << refused;
  EXPECT_NE(refused.find("temporary directory"), std::string::npos) << refused;
  EXPECT_EQ(status("/healthz").find(" 200 "), 8u);

  fs::remove(place);
  for (int i = 0; i < 1500 && status("/readyz").find(" 200 ") != 8; ++i) std::this_thread::sleep_for(20ms);
  EXPECT_EQ(status("/readyz").find(" 200 "), 8u);
  EXPECT_EQ(status(image).find(" 200 "), 8u) << "what failed before is drawn now";
}

// What a dead worker has left may not be removable: here it is deeper than a server with few descriptors can walk.
TEST_F(ServeCommand, WhatADeadWorkerLeavesBehindIsInNobodysWay) {
  const fs::path place = directory_ / "temporary";
  fs::create_directory(place);
  setenv("TMPDIR", place.c_str(), 1);
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  rlimit few = before;
  few.rlim_cur = 300;
  setrlimit(RLIMIT_NOFILE, &few);
  struct Restore {
    rlimit limit;
    ~Restore() {
      unsetenv("TMPDIR");
      setrlimit(RLIMIT_NOFILE, &limit);
    }
  } restore{before};
  const std::string token = "the-same-token-in-every-life";
  SERVE_OR_SKIP({"torus:12", "--token", token});
  setrlimit(RLIMIT_NOFILE, &before);
  const auto port = static_cast<unsigned short>(ready_.at("port").to_number<int>());
  const std::string session(
      Asked(port, token, "POST", "sessions", R"({"dataset": "torus-12"})").answer(201).at("id").as_string());
  for (int death = 0; death < 2; ++death) {
    const auto worker = Asked(port, token, "GET", "engine").answer(200).at("process").to_number<pid_t>();
    ASSERT_GT(worker, 0);
    for (const auto& server : fs::directory_iterator(place))
      for (const auto& folder : fs::directory_iterator(server.path())) {
        if (!folder.path().filename().string().starts_with("worker")) continue;
        const int here = open(".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        fs::current_path(folder.path());
        for (int i = 0; i < 500; ++i) {
          if (mkdir("deep", 0700) != 0 || chdir("deep") != 0) break;
        }
        EXPECT_EQ(fchdir(here), 0);
        close(here);
      }
    kill(worker, SIGKILL);
    EXPECT_TRUE(soon_gone(worker));
    isostrata::RawSocket socket(port);
    socket.send("GET /api/v1/sessions/" + session + "/image?width=64&height=48 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" +
                "Authorization: Bearer " + token + "\r\n\r\n");
    EXPECT_EQ(socket.read_all(nullptr, 30000).find(" 200 "), 8u);
  }
  stop(SIGKILL);
}

TEST_F(ServeCommand, AWorkerEndsWithItsServerHoweverThatEnds) {
  for (const int signal : {SIGTERM, SIGKILL}) {
    SERVE_OR_SKIP({"torus:12"});
    const pid_t worker = ready_.at("worker").to_number<pid_t>();
    ASSERT_GT(worker, 0);
    EXPECT_NE(worker, server_);
    EXPECT_TRUE(runs(worker));
    for (const int meant_for_the_server : {SIGINT, SIGTERM, SIGHUP}) kill(worker, meant_for_the_server);
    ASSERT_EQ(run("isostrata-client", {url_, "info"}), 0) << read_text(errors());
    EXPECT_TRUE(runs(worker)) << "a job's signals reach all of its processes; the server ends the worker";
    stop(signal);
    EXPECT_TRUE(soon_gone(worker)) << "after signal " << signal;
  }
}

TEST_F(ServeCommand, AKilledWorkerIsReplaced) {
  SERVE_OR_SKIP({"torus:12"});
  const pid_t worker = ready_.at("worker").to_number<pid_t>();
  ASSERT_GT(worker, 0);
  kill(worker, SIGKILL);
  EXPECT_TRUE(soon_gone(worker));
  const std::string picture = (directory_ / "a.png").string();
  ASSERT_EQ(run("isostrata-client", {url_, "snapshot", "--interval", "0.2:0.5", "--size", "120x90", "--out", picture}), 0)
      << read_text(errors());
  EXPECT_TRUE(read_text(picture).starts_with("\x89PNG"));
  EXPECT_EQ(stop(SIGTERM), 0);
}

TEST_F(ServeCommand, TextThatIsNoUtf8IsRefusedAndFillsNoLog) {
  SERVE_OR_SKIP({"torus:12", "--no-auth"});
  const auto port = static_cast<unsigned short>(ready_.at("port").to_number<int>());
  const std::string hello("\x08\x01\x12\x06\x08\x01\x1a\x02\xff\xfe", 10);  // seq 1, and a Hello whose client has this name
  for (int i = 0; i < 40; ++i) {
    isostrata::RawSocket socket(port);
    ASSERT_NE(socket.open_websocket("/ws").find(" 101 "), std::string::npos);
    socket.send_frame(hello);
    socket.send_frame(std::string("\x03\xe8", 2), 8);
    EXPECT_NE(socket.read_all().find("malformed"), std::string::npos);
  }
  EXPECT_EQ(stop(SIGTERM), 0);
  const std::string log = read_text(errors());
  EXPECT_EQ(log.find("libprotobuf"), std::string::npos) << log;
  int lines = 0;
  for (std::size_t at = log.find("UTF-8"); at != std::string::npos; at = log.find("UTF-8", at + 1)) ++lines;
  EXPECT_GE(lines, 1) << log;
  EXPECT_LE(lines, 3) << log;
}

TEST_F(ServeCommand, SessionsAreJoinedByIdAndSeeTheSame) {
  SERVE_OR_SKIP({"torus:12"});
  ASSERT_EQ(run("isostrata-client", {url_, "info", "--json"}), 0);
  const std::string id(json::parse(read_text(out())).at("session").as_string());
  ASSERT_EQ(run("isostrata-client",
                {url_, "snapshot", "--session", id, "--interval", "0.2:0.3", "--out", (directory_ / "a.png").string()}),
            0)
      << read_text(errors());
  ASSERT_EQ(run("isostrata-client", {url_, "info"}), 0) << read_text(errors());
  EXPECT_NE(read_text(out()).find("living   " + id), std::string::npos) << read_text(out());
  ASSERT_EQ(run("isostrata-client", {url_, "info", "--json", "--session", id}), 0) << read_text(errors());
  const auto state = json::parse(read_text(out())).at("state");
  EXPECT_EQ(state.at("intervals").as_array().size(), 1u);
}

TEST_F(ServeCommand, WrongTokensAndWrongUsageAreSaid) {
  SERVE_OR_SKIP({"torus:12"});
  const std::string base = url_.substr(0, url_.find('?'));
  EXPECT_EQ(run("isostrata-client", {base + "?token=wrong", "info"}), 1);
  EXPECT_NE(read_text(errors()).find("401"), std::string::npos) << read_text(errors());
  EXPECT_EQ(run("isostrata-client", {"not-a-url", "info"}), 2);
  EXPECT_EQ(run("isostrata-client", {url_}), 2);
  EXPECT_EQ(run("isostrata-client", {url_, "snapshot"}), 2);
  EXPECT_EQ(run("isostrata-client", {url_, "snapshot", "--interval", "2:1", "--out", (directory_ / "a.png").string()}), 1);
  EXPECT_EQ(run("isostrata-client", {url_, "snapshot", "--dataset", "nosuch", "--out", (directory_ / "a.png").string()}), 1);
}

TEST_F(ServeCommand, WhatCannotBeServedIsRefusedInOneLine) {
  struct Case {
    std::vector<std::string> arguments;
    int status;
    const char* says;
  };
  const std::vector<Case> cases = {
      {{"serve", "/no/such/file.vtk"}, 1, "/no/such/file.vtk"},
      {{"serve", "--host", "256.1.1.1", "torus:12"}, 1, "256.1.1.1"},
      {{"serve", "--token", "short", "torus:12"}, 1, "token"},
      {{"serve", "--token-file", "/no/such/token", "torus:12"}, 1, "/no/such/token"},
      {{"serve", "--base-url", "/a/../b", "torus:12", "--port", "0"}, 1, "base url"},
      {{"serve", "--device", "nonsense", "torus:12", "--port", "0"}, 1, "nonsense"},
      {{"serve", "--port", "70000"}, 2, ""},
      {{"serve", "--no-auth", "--token", "a-long-enough-token"}, 2, ""},
      {{"serve", "--nonsense"}, 2, ""},
  };
  for (const Case& wrong : cases) {
    EXPECT_EQ(run("isostrata", wrong.arguments), wrong.status) << wrong.arguments[1] << ": " << read_text(errors());
    EXPECT_NE(read_text(errors()).find(wrong.says), std::string::npos) << read_text(errors());
  }
}

}  // namespace
