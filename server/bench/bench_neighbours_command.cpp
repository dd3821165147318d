// What one session's heavy work costs another one: a real server with its worker, both sessions over real sockets. The polite
// session turns a camera; its frames are measured beside an idle neighbour, beside each work, and after it.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "base/error.h"
#include "base/parallel.h"
#include "base/program_file.h"
#include "base/simd_level.h"
#include "base/spawn.h"
#include "base/temporary_directory.h"
#include "bench/bench_sums.h"
#include "bench/commands.h"
#include "bench/neighbour_works.h"
#include "bench/plain_socket.h"
#include "bench/turning_camera.h"
#include "session/wire/random_token.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr auto kTurnEvery = milliseconds(50);
constexpr auto kStartTime = std::chrono::seconds(30);
constexpr const char* kPoliteData = "torus-16";

double seconds_since(Clock::time_point then) { return std::chrono::duration<double>(Clock::now() - then).count(); }

/// `isostrata serve` with its worker, in processes of their own.
class ServeProcess {
 public:
  ServeProcess(const fs::path& program, const std::vector<std::string>& more) : folder_(temporary_base(), "isostrata-bench-"), token_(random_token(192)) {
    const fs::path ready = folder_.path() / "ready.json";
    std::vector<std::string> words{"isostrata",     "serve",        "--port",         "0",
                                   "--token",       token_,         "--ready-file",   ready.string(),
                                   "--max-viewers", "100",          "--idle-timeout", "60"};
    words.insert(words.end(), more.begin(), more.end());
    for (std::string& data : neighbour_data(folder_.path() / "data")) words.push_back(std::move(data));
    std::vector<std::string> environment = environment_without({"ISOSTRATA_CACHE"});
    environment.push_back("ISOSTRATA_CACHE=off");  // what is opened is read
    const int log = open((folder_.path() / "log").c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    const int error = spawn_in_group(id_, {.program = program, .words = words, .environment = environment, .descriptors = {-1, log, log}});
    close(log);
    if (error != 0) throw Error(ErrorCode::unavailable, "the server could not be started");
    for (const auto began = Clock::now(); !fs::exists(ready);) {
      if (Clock::now() - began > kStartTime || waitpid(id_, nullptr, WNOHANG) != 0)
        throw Error(ErrorCode::unavailable, "the server does not answer");
      std::this_thread::sleep_for(milliseconds(20));
    }
    std::ifstream file(ready);
    const json::object facts = json::parse(std::string(std::istreambuf_iterator<char>(file), {})).as_object();
    port_ = facts.at("port").to_number<unsigned short>();
    device_ = std::string(facts.at("device").as_string());
  }
  ~ServeProcess() {
    kill(id_, SIGTERM);
    waitpid(id_, nullptr, 0);
  }
  ServeProcess(const ServeProcess&) = delete;
  ServeProcess& operator=(const ServeProcess&) = delete;

  unsigned short port() const { return port_; }
  const std::string& token() const { return token_; }
  const std::string& device() const { return device_; }

  HeavySession session(const std::string& dataset) const {
    HeavySession made{port_, token_, ""};
    made.id = std::string(json::parse(made.ask("POST", "", json::serialize(json::object{{"dataset", dataset}}))).as_object().at("id").as_string());
    return made;
  }
  /// Of the server and its worker, without what files can give back. Looking costs next to nothing, ten times a second.
  double resident_mb() {
    if (seconds_since(looked_) < 0.1) return resident_mb_;
    looked_ = Clock::now();
    std::uint64_t bytes = anonymous_bytes(id_);
    std::error_code error;
    for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(id_) + "/task", error)) {
      std::ifstream children(thread.path() / "children");
      for (pid_t child = 0; children >> child;) bytes += anonymous_bytes(child);
    }
    return resident_mb_ = static_cast<double>(bytes >> 10) / 1024;
  }

 private:
  const TemporaryDirectory folder_;
  const std::string token_;
  pid_t id_ = 0;
  Clock::time_point looked_;
  double resident_mb_ = 0;
  unsigned short port_ = 0;
  std::string device_;
};

struct Seen {
  std::vector<double> latency_ms;  // of each input that a frame showed
  double longest_gap_ms = 0;
  int frames = 0;

  double p95() const {
    if (latency_ms.empty()) return 0;
    std::vector<double> sorted = latency_ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(0.95 * static_cast<double>(sorted.size() - 1))];
  }
};

/// The session that is measured: a page of 640x480 whose camera turns 20 times a second, in a thread of its own.
class PoliteViewer {
 public:
  explicit PoliteViewer(const ServeProcess& server) : socket_(server.port(), server.token()) {
    v1::ClientMessage hello, open, viewport;
    hello.mutable_hello()->set_protocol_major(1);
    hello.mutable_hello()->add_still_formats("png");
    hello.mutable_hello()->add_still_formats("png-bands");
    hello.mutable_hello()->add_moving_formats("jpeg");
    open.mutable_open_dataset()->set_id(kPoliteData);
    viewport.mutable_viewport()->set_width(640);
    viewport.mutable_viewport()->set_height(480);
    socket_.add(hello);
    socket_.add(open);
    socket_.add(viewport);
    v1::ClientMessage holds;  // the button is down
    holds.mutable_interaction()->set_active(true);
    socket_.add(holds);
    if (!socket_.open() || !socket_.flush(1000)) throw Error(ErrorCode::unavailable, "the server takes no viewer");
    thread_ = std::thread([this] { live(); });
  }
  ~PoliteViewer() {
    stop_ = true;
    thread_.join();
  }

  /// Turns until `until` says so, at least so long.
  template <class Until>
  Seen turn(double at_least_s, const Until& until) {
    {
      const std::lock_guard lock(mutex_);
      seen_ = {};
      inputs_.clear();
      last_ = Clock::now();
    }
    turning_ = true;
    for (const auto began = Clock::now(); seconds_since(began) < at_least_s || !until();) std::this_thread::sleep_for(milliseconds(10));
    turning_ = false;
    const std::lock_guard lock(mutex_);
    note_gap();
    // What is still without a picture waits for as long as that.
    for (const auto& [number, sent] : inputs_)
      if (seconds_since(sent) > 0.25) seen_.latency_ms.push_back(1000 * seconds_since(sent));
    return std::exchange(seen_, {});
  }

 private:
  void note_gap() {
    seen_.longest_gap_ms = std::max(seen_.longest_gap_ms, 1000 * seconds_since(last_));
    last_ = Clock::now();
  }

  void live() {
    auto next = Clock::now();
    double angle = 0;
    while (!stop_ && socket_.open()) {
      if (turning_ && Clock::now() >= next) {
        next = std::max(next + kTurnEvery, Clock::now());
        const std::lock_guard lock(mutex_);
        inputs_[socket_.add(turning_camera(5, angle += 0.03))] = Clock::now();
      }
      socket_.flush();
      socket_.receive(1 << 16, 2);
      while (const auto bytes = socket_.next()) take(*bytes);
    }
  }

  void take(const std::string& bytes) {
    v1::ServerMessage message;
    if (bytes.empty() || !message.ParseFromString(bytes) || !message.has_frame()) return;
    v1::ClientMessage ack;
    ack.mutable_frame_ack()->set_frame_id(message.frame().frame_id());
    socket_.add(ack);
    if (!turning_) return;
    const std::lock_guard lock(mutex_);
    ++seen_.frames;
    note_gap();
    while (!inputs_.empty() && inputs_.begin()->first <= message.frame().input_seq()) {
      seen_.latency_ms.push_back(1000 * seconds_since(inputs_.begin()->second));
      inputs_.erase(inputs_.begin());
    }
  }

  PlainSocket socket_;
  std::atomic<bool> stop_{false}, turning_{false};
  std::mutex mutex_;  // guards what follows
  std::map<std::uint64_t, Clock::time_point> inputs_;  // that no frame has shown yet
  Clock::time_point last_;                             // frame
  Seen seen_;
  std::thread thread_;
};

struct NeighboursArguments {
  std::vector<std::string> works;
  double most_s = 12, window_s = 2;
  std::string program = (program_file().parent_path() / "isostrata").string();
  std::vector<std::string> serve;
  bool json = false;
};

/// A work in a thread of its own, once or again and again.
class Running {
 public:
  Running(const NeighbourWork& work, const HeavySession& session, bool again)
      : thread_([this, &work, session, again] {
          const auto began = Clock::now();
          try {
            do {
              ok_ = work.work(session, stop_);
              ++times_;
            } while (again && ok_ && !stop_ && seconds_since(began) < 2);
          } catch (const std::exception& error) {
            ok_ = false;
            problem_ = error.what();
          }
          took_s_ = seconds_since(began) / std::max(1, times_);
          done_ = true;
        }) {}
  ~Running() { end(); }
  bool done() const { return done_; }
  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  /// After its end: seconds for once; nothing if it was stopped or failed.
  std::optional<double> took_s() const { return ok_ && whole_ ? std::optional(took_s_) : std::nullopt; }
  void cut_short() { whole_ = false; }
  bool failed() const { return whole_ && !ok_; }
  const std::string& problem() const { return problem_; }

 private:
  std::atomic<bool> stop_{false}, done_{false};
  bool ok_ = false, whole_ = true;
  int times_ = 0;
  double took_s_ = 0;
  std::string problem_;
  std::thread thread_;
};

json::value number(const std::optional<double>& of) { return of ? json::value(*of) : json::value(nullptr); }

json::object measure(ServeProcess& server, PoliteViewer& polite, const NeighbourWork& work, const NeighboursArguments& arguments) {
  const HeavySession session = server.session(work.dataset);
  if (work.prepare) work.prepare(session);
  {  // its mesh is there, as it is for whoever looks at it
    std::atomic<bool> never{false};
    plain_request(session.port, session.token, "GET", "/api/v1/sessions/" + session.id + "/image?width=64&height=64", "", never);
  }
  const auto idle = [] { return true; };
  const Seen before = polite.turn(arguments.window_s, idle);

  std::optional<double> alone_s;
  if (work.ends) {
    Running running(work, session, true);
    const auto began = Clock::now();
    while (!running.done() && seconds_since(began) < arguments.most_s) std::this_thread::sleep_for(milliseconds(5));
    if (!running.done()) running.cut_short();
    running.end();
    if (running.failed()) throw Error(ErrorCode::unavailable, work.name + " failed: " + running.problem());
    alone_s = running.took_s();
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }

  double peak = 0;
  std::optional<double> beside_s;
  Seen beside;
  {
    Running running(work, session, true);
    const auto began = Clock::now();
    beside = polite.turn(work.ends ? 1 : 3 * arguments.window_s, [&] {
      peak = std::max(peak, server.resident_mb());
      return !work.ends || running.done() || seconds_since(began) > 2 * arguments.most_s;
    });
    if (!running.done()) running.cut_short();
    running.end();
    beside_s = work.ends ? running.took_s() : std::nullopt;
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const Seen after = polite.turn(arguments.window_s, idle);
  session.ask("DELETE", "");
  return {{"work", work.name},
          {"alone_p95_ms", before.p95()},
          {"alone_gap_ms", before.longest_gap_ms},
          {"beside_p95_ms", beside.p95()},
          {"longest_gap_ms", beside.longest_gap_ms},
          {"after_p95_ms", after.p95()},
          {"after_gap_ms", after.longest_gap_ms},
          {"work_alone_s", number(alone_s)},
          {"work_beside_s", number(beside_s)},
          {"frames_beside", beside.frames},
          {"memory_peak_mb", peak}};
}

void print_neighbours(const json::object& run) {
  const auto of = [&](const char* key) { return run.at(key).is_null() ? std::nan("") : run.at(key).to_number<double>(); };
  const double limit = 1.2 * of("alone_p95_ms") + 20;
  const bool fair = of("beside_p95_ms") <= limit && of("longest_gap_ms") <= 250 &&
                    !(of("work_beside_s") > 1.5 * of("work_alone_s")) && of("after_p95_ms") <= limit;
  std::printf("%-30s %6.0f %7.0f %7.0f %7.0f %9.2f %9.2f %9.0f  %s\n", run.at("work").as_string().c_str(), of("alone_p95_ms"),
              of("beside_p95_ms"), of("longest_gap_ms"), of("after_p95_ms"), of("work_alone_s"), of("work_beside_s"),
              of("memory_peak_mb"), fair ? "" : "NOT FAIR");
  std::fflush(stdout);
}

void run(const NeighboursArguments& arguments) {
  ServeProcess server(fs::canonical(arguments.program), arguments.serve);
  PoliteViewer polite(server);
  polite.turn(1, [] { return true; });  // everything is loaded and warm
  json::array runs;
  if (!arguments.json)
    std::printf("%s\nthe other session's frames, ms   the work, s\n%-30s %6s %7s %7s %7s %9s %9s %9s\n", server.device().c_str(), "work",
                "alone", "beside", "gap", "after", "alone", "beside", "MB");
  for (const NeighbourWork& work : neighbour_works()) {
    const auto& wanted = arguments.works;
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), work.name) == wanted.end()) continue;
    json::object one = measure(server, polite, work, arguments);
    if (!arguments.json) print_neighbours(one);
    runs.push_back(std::move(one));
  }
  if (arguments.json)
    print_json(json::object{{"runs", std::move(runs)}, {"device", server.device()}, {"threads", thread_count()}, {"simd", simd_level()}});
}

}  // namespace

void add_bench_neighbours_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand("neighbours", "What each heavy work of one session costs another session's frames, and the work");
  const auto arguments = std::make_shared<NeighboursArguments>();
  std::vector<std::string> names;
  for (const NeighbourWork& work : neighbour_works()) names.push_back(work.name);
  command->add_option("--work", arguments->works, "Only this one; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::IsMember(names));
  command->add_option("--most", arguments->most_s, "Seconds after which a work is cut short")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  command->add_option("--window", arguments->window_s, "Seconds that frames are measured for, alone and after")
      ->check(CLI::Range(0.5, 60.0))
      ->capture_default_str();
  command->add_option("--program", arguments->program, "Another build of isostrata, to serve in place of the one beside")->check(CLI::ExistingFile);
  command->add_option("--serve", arguments->serve, "One more word for `isostrata serve`; may be repeated")->allow_extra_args(false);
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
