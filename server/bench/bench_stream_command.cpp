// Frames of a turning camera as a viewer gets them: a real server in this process, isostrata-client in a process of its own, real
// sockets between them, and a link of a given delay and rate.
//
// Links: "loopback", "40ms-20mbit", "20mbit" and, falling within a second in the middle of the run, "40ms-20mbit-to-2mbit".
#include <sys/resource.h>

#include <algorithm>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <thread>

#include "base/error.h"
#include "base/parallel.h"
#include "base/simd_level.h"
#include "bench/bench_server.h"
#include "bench/commands.h"
#include "bench/hostile_client.h"
#include "bench/shaped_link.h"
#include "data/open/child_process.h"
#include "engine/first/first_view.h"
#include "main/arguments.h"
#include "main/picture_arguments.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr auto kFall = std::chrono::milliseconds(1000);                                // from the first rate to the second
constexpr double kFallsAfter = 0.4;                                                    // of the run
constexpr const char *kDefaultData = "cylinder", *kDefaultInterval = "0.9934:0.9949";  // the paper's, tapered: 55.6 K tetrahedra
constexpr const char *kNeighbourData = "torus:12", *kNeighbourId = "torus-12";

struct StreamArguments {
  std::string data = kDefaultData;
  std::vector<std::string> intervals;
  std::vector<std::string> links{"loopback", "40ms-20mbit", "80ms-2mbit", "40ms-20mbit-to-2mbit", "20ms-5mbit"};
  std::string size = "1280x720", codec = "auto", renderer = "native", device = "auto";
  std::string camera;  // where a session that has opened the data stands
  double seconds = 8, rate = 60;
  int viewers = 0, silent = 0;
  std::vector<std::string> hostile;  // manners of a neighbour; none: nobody else is there
  int rounds = 3;                    // with each of them
  int threads = 0;
  bool json = false, timeline = false;
};

struct LinkArgument {
  LinkShape shape;
  std::optional<double> falls_to;  // bits per second
  bool loopback() const { return shape.round_trip.count() == 0 && shape.bits_per_second == 0; }
};

/// Throws invalid_argument.
LinkArgument parse_link(const std::string& name) {
  LinkArgument link;
  if (name == "loopback") return link;
  std::vector<std::string> parts{""};
  for (const char c : name) c == '-' ? void(parts.emplace_back()) : parts.back().push_back(c);
  const auto take = [&](std::string_view unit) -> std::optional<double> {
    if (parts.empty() || !parts.front().ends_with(unit)) return std::nullopt;
    const std::string& text = parts.front();
    double value = 0;
    const char* end = text.data() + text.size() - unit.size();
    if (const auto [at, error] = std::from_chars(text.data(), end, value);
        error != std::errc{} || at != end || !(value > 0) || value > 1e5)
      return std::nullopt;
    parts.erase(parts.begin());
    return value;
  };
  bool known = false;
  if (const auto ms = take("ms")) {
    link.shape.round_trip = std::chrono::microseconds(static_cast<std::int64_t>(*ms * 1000));
    known = true;
  }
  if (const auto mbit = take("mbit")) {
    link.shape.bits_per_second = *mbit * 1e6;
    known = true;
    if (!parts.empty() && parts.front() == "to") {
      parts.erase(parts.begin());
      const auto to = take("mbit");
      known = to.has_value();
      link.falls_to = to ? std::optional(*to * 1e6) : std::nullopt;
    }
  }
  if (!known || !parts.empty())
    throw Error(ErrorCode::invalid_argument,
                "link '" + name + "': expected loopback, or RTTms-RATEmbit such as 40ms-20mbit or 40ms-20mbit-to-2mbit");
  return link;
}

/// Lowers the rate in ten steps once the run is under way; the time when it has fallen, in ms of the steady clock.
double fall(ShapedLink& link, const LinkArgument& from, double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(kFallsAfter * seconds));
  constexpr int kSteps = 10;
  for (int i = 1; i <= kSteps; ++i) {
    LinkShape shape = from.shape;
    shape.bits_per_second += (*from.falls_to - from.shape.bits_per_second) * i / kSteps;
    link.reshape(shape);
    std::this_thread::sleep_for(kFall / kSteps);
  }
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Of inputs sent from `since_ms` on (steady clock).
json::object after(const json::object& timeline, double since_ms) {
  std::vector<double> latency;
  for (const json::value& input : timeline.at("inputs").as_array())
    if (input.at(0).to_number<double>() >= since_ms) latency.push_back(input.at(1).to_number<double>());
  if (latency.empty()) return {};
  std::sort(latency.begin(), latency.end());
  const auto at = [&](double p) { return latency[static_cast<std::size_t>(p * static_cast<double>(latency.size() - 1))]; };
  return {{"p50", at(0.5)}, {"p95", at(0.95)}, {"max", latency.back()}};
}

/// Bytes of memory that this process, and so the server, has.
double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * 4096 / (1 << 20);
}

json::object measure(const BenchServer& server, const StreamArguments& arguments, const std::string& name,
                     const std::string& reference) {
  const LinkArgument link = parse_link(name);
  std::unique_ptr<ShapedLink> shaped;
  if (!link.loopback()) shaped = std::make_unique<ShapedLink>(server.port(), link.shape);
  std::vector<std::string> words{server.url(shaped ? shaped->port() : server.port()),
                                 "latency",
                                 "--json",
                                 "--turn",
                                 "--camera",
                                 arguments.camera,
                                 "--size",
                                 arguments.size,
                                 "--codec",
                                 arguments.codec,
                                 "--seconds",
                                 std::to_string(arguments.seconds),
                                 "--rate",
                                 std::to_string(arguments.rate)};
  for (const std::string& interval : arguments.intervals) words.insert(words.end(), {"--interval", interval});
  if (!reference.empty()) words.insert(words.end(), {"--reference", reference});
  const ScratchFile timeline(".json");
  words.insert(words.end(), {"--timeline", timeline.path.string()});
  if (arguments.viewers > 0) words.insert(words.end(), {"--viewers", std::to_string(arguments.viewers)});
  if (arguments.silent > 0) words.insert(words.end(), {"--silent", std::to_string(arguments.silent)});

  double fallen_at_ms = 0;
  std::thread falling;
  if (link.falls_to) falling = std::thread([&] { fallen_at_ms = fall(*shaped, link, arguments.seconds); });
  json::object run;
  try {
    run = run_json(beside_this_program("isostrata-client"), words, arguments.seconds + 120).as_object();
  } catch (...) {
    if (falling.joinable()) falling.join();
    throw;
  }
  if (falling.joinable()) falling.join();
  run["link"] = name;
  run["data"] = arguments.data;
  run["server_mib"] = resident_mib();
  if (arguments.viewers > 0) run["viewers"] = arguments.viewers + 1;
  if (arguments.silent > 0) run["silent"] = arguments.silent;
  std::ifstream file(timeline.path);
  json::value told = json::parse(std::string(std::istreambuf_iterator<char>(file), {}));
  if (link.falls_to) {
    run["fallen_at_ms"] = fallen_at_ms;
    run["after_2s_ms"] = after(told.as_object(), fallen_at_ms + 2000);
  }
  if (arguments.timeline) run["timeline"] = std::move(told);
  return run;
}

double number(const json::object& of, const char* key) { return of.contains(key) ? of.at(key).to_number<double>() : 0; }

void print_stream(const json::object& run) {
  const json::object& ms = run.at("input_to_decoded_ms").as_object();
  std::printf(
      "%-22s %-8s %5.1f fps  input to decoded ms p50 %.0f p95 %.0f max %.0f  stale %.0f  %.0f bytes  rest to lossless %.0f "
      "ms%s\n",
      run.at("link").as_string().c_str(), run.at("codec").as_string().c_str(), number(run, "fps"), number(ms, "p50"),
      number(ms, "p95"), number(ms, "max"), number(run, "stale_max_ms"), number(run, "bytes_per_frame"),
      number(run, "rest_to_lossless_ms"),
      !run.contains("lossless_differs")                           ? ""
      : run.at("lossless_differs").to_number<std::int64_t>() == 0 ? ", bit-exact"
                                                                  : ", NOT what render draws");
  if (const auto* after = run.if_contains("after_2s_ms"); after && !after->as_object().empty())
    std::printf("%-22s 2 s after the fall p50 %.0f p95 %.0f max %.0f\n", "", number(after->as_object(), "p50"),
                number(after->as_object(), "p95"), number(after->as_object(), "max"));
  if (run.contains("viewers_latency_ms")) {
    const json::object& others = run.at("viewers_latency_ms").as_object();
    std::printf("%-22s other viewers: %.0f frames, p50 %.0f p95 %.0f ms; the server has %.0f MiB\n", "",
                number(run, "viewers_frames"), number(others, "p50"), number(others, "p95"), number(run, "server_mib"));
  }
  std::fflush(stdout);
}

/// That this process, and so the server with its neighbour, has used.
double cpu_seconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& of) { return static_cast<double>(of.tv_sec) + 1e-6 * static_cast<double>(of.tv_usec); };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// The same link alone and with each neighbour, in turns, so that a machine that others slow down slows down all of them; each
/// round begins with another of them.
json::array measure_with_neighbours(const BenchServer& server, const StreamArguments& arguments, const std::string& link,
                                    const std::string& reference) {
  json::array runs;
  std::vector<std::string> all{"none"};
  all.insert(all.end(), arguments.hostile.begin(), arguments.hostile.end());
  struct Measured {
    std::vector<double> p95_ms, cores;  // of the server
  };
  std::map<std::string, Measured> measured;
  for (int round = 0; round < arguments.rounds; ++round)
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::string& manners = all[(i + static_cast<std::size_t>(round)) % all.size()];
      std::unique_ptr<HostileClient> neighbour;
      if (manners != "none") neighbour = std::make_unique<HostileClient>(server.port(), server.token(), kNeighbourId, manners);
      const auto began = std::chrono::steady_clock::now();
      const double used = cpu_seconds() - (neighbour ? neighbour->cpu_seconds() : 0);
      json::object one = measure(server, arguments, link, reference);
      const double cores = (cpu_seconds() - (neighbour ? neighbour->cpu_seconds() : 0) - used) /
                           std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
      one["hostile"] = manners;
      one["server_cores"] = cores;
      if (neighbour) {
        one["hostile_messages"] = neighbour->messages();
        one["hostile_connections"] = neighbour->connections();
      }
      measured[manners].p95_ms.push_back(number(one.at("input_to_decoded_ms").as_object(), "p95"));
      measured[manners].cores.push_back(cores);
      if (!arguments.json) std::printf("%-12s ", manners.c_str()), print_stream(one);
      runs.push_back(std::move(one));
    }
  if (arguments.json) return runs;
  std::printf("%-14s p95 ms: least  median  greatest   server's cores, median\n", "neighbour");
  for (const std::string& manners : all) {
    auto& [p95, cores] = measured[manners];
    std::sort(p95.begin(), p95.end());
    std::sort(cores.begin(), cores.end());
    std::printf("  %-12s %13.0f %7.0f %9.0f %17.2f\n", manners.c_str(), p95.front(), p95[p95.size() / 2], p95.back(),
                cores[cores.size() / 2]);
  }
  return runs;
}

void run(StreamArguments arguments) {
  parse_size(arguments.size);
  for (const std::string& link : arguments.links) parse_link(link);
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  const FirstView view = first_view_of(arguments.data);
  arguments.camera = camera_text(view, arguments.size);
  if (arguments.intervals.empty() && arguments.data == kDefaultData) arguments.intervals.push_back(kDefaultInterval);
  for (std::string& interval : arguments.intervals)
    if (interval.find("opacity") == std::string::npos) interval += ",color=#e61f1f,opacity=0.6";
  // What rest must show, made by the command whose pictures are the measure.
  const ScratchFile reference(".png");
  std::vector<std::string> words{"render",           arguments.data, "--size",         arguments.size, "--renderer",
                                 arguments.renderer, "--device",     arguments.device, "--out",        reference.path.string(),
                                 "--camera",         arguments.camera};
  if (!arguments.intervals.empty()) words.insert(words.end(), {"--array", view.array, "--step", std::to_string(view.step)});
  for (const std::string& interval : arguments.intervals) words.insert(words.end(), {"--interval", interval});
  const ChildResult rendered = run_child({beside_this_program("isostrata"), words, {}}, 300, command_task(), [](std::string_view) {});
  if (rendered.exit_status != 0 || rendered.signal != 0)
    throw Error(ErrorCode::unavailable, "isostrata render failed: " + rendered.errors);
  json::array runs;
  {
    std::vector<std::string> data{arguments.data};
    if (!arguments.hostile.empty()) data.emplace_back(kNeighbourData);
    const BenchServer server(data, arguments.renderer, arguments.device);
    for (const std::string& link : arguments.links) {
      if (!arguments.hostile.empty()) {
        for (json::value& one : measure_with_neighbours(server, arguments, link, reference.path.string()))
          runs.push_back(std::move(one));
        continue;
      }
      json::object one = measure(server, arguments, link, reference.path.string());
      if (!arguments.json) print_stream(one);
      runs.push_back(std::move(one));
    }
  }
  if (arguments.json) print_json(json::object{{"runs", std::move(runs)}, {"threads", thread_count()}, {"simd", simd_level()}});
}

}  // namespace

void add_bench_stream_command(CLI::App& bench) {
  CLI::App* command =
      bench.add_subcommand("stream", "Frames per second and latency of a turning camera, by a real server and client over links of all kinds");
  auto arguments = std::make_shared<StreamArguments>();
  command->add_option("--data", arguments->data, "File or name of analytic data")->capture_default_str();
  command
      ->add_option("--interval", arguments->intervals,
                   "As in render; may be repeated (default: 0.9934:0.9949 of the cylinder, of other data the layers that serve "
                   "begins with)")
      ->allow_extra_args(false);
  command
      ->add_option("--link", arguments->links,
                   "loopback, or RTTms-RATEmbit, or RTTms-RATEmbit-to-RATEmbit, which falls within a second; may be repeated")
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command->add_option("--codec", arguments->codec, "Of frames in motion: auto (by measured times), jpeg or vp9-444")
      ->check(CLI::IsMember({"auto", "jpeg", "vp9-444"}))
      ->capture_default_str();
  command->add_option("--seconds", arguments->seconds, "How long the camera turns, for each link")
      ->check(CLI::Range(0.5, 3600.0))
      ->capture_default_str();
  command->add_option("--rate", arguments->rate, "Inputs a second, and so the most frames a second")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  command->add_option("--viewers", arguments->viewers, "Further viewers of the same session")->check(CLI::Range(0, 1000));
  command->add_option("--silent", arguments->silent, "And viewers that never read")->check(CLI::Range(0, 1000));
  command
      ->add_option("--hostile", arguments->hostile,
                   "A neighbour in a session of its own, measured in turns with none; may be repeated: polite, flood, "
                   "flood-hidden, reader, vanish, garbage")
      ->allow_extra_args(false)
      ->check(CLI::IsMember(hostile_manners()));
  command->add_option("--rounds", arguments->rounds, "With --hostile: how often each is measured")->check(CLI::Range(1, 1000));
  command->add_option("--renderer", arguments->renderer, "auto, native, raster or compute")
      ->check(CLI::IsMember({"auto", "native", "raster", "compute"}))
      ->capture_default_str();
  command->add_option("--device", arguments->device, "auto, egl:INDEX, egl:UUID, surfaceless or osmesa")->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command->add_flag("--timeline", arguments->timeline,
                    "In JSON also every input and frame, as isostrata-client latency tells them");
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
