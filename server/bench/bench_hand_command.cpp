// How quickly a picture follows a hand that turns what a session begins with, dataset by dataset, lit as it is: a real server in
// this process, isostrata-client in a process of its own, loopback between them.
#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>

#include "base/error.h"
#include "base/parallel.h"
#include "base/simd_level.h"
#include "bench/bench_server.h"
#include "bench/commands.h"
#include "main/arguments.h"
#include "main/picture_arguments.h"

namespace isostrata {
namespace {

namespace json = boost::json;

struct HandArguments {
  std::vector<std::string> data{"torus"};
  std::string size = "1280x720", gesture = "turn", renderer = "native", device = "auto";
  double seconds = 4;
  bool json = false;
};

double number(const json::value& of, const char* key) { return of.at(key).to_number<double>(); }

/// The size of most of the moving pictures: [width, height].
json::array usual_size(const json::value& timeline) {
  std::map<std::pair<std::int64_t, std::int64_t>, int> counts;
  for (const json::value& frame : timeline.at("frames").as_array())
    ++counts[{frame.at(3).to_number<std::int64_t>(), frame.at(4).to_number<std::int64_t>()}];
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? json::array{} : json::array{most->first.first, most->first.second};
}

json::object measure(const HandArguments& arguments, const std::string& data) {
  const BenchServer server({data}, arguments.renderer, arguments.device);
  const FirstView view = first_view_of(data);
  const ScratchFile timeline(".json");
  std::vector<std::string> words{server.url(server.port()),         "latency",    "--json",         "--camera",
                                 camera_text(view, arguments.size), "--size",     arguments.size,   "--seconds",
                                 std::to_string(arguments.seconds), "--timeline", timeline.path.string()};
  if (arguments.gesture == "turn") words.emplace_back("--turn");
  const json::value run = run_json(beside_this_program("isostrata-client"), words, arguments.seconds + 300);
  std::ifstream file(timeline.path);
  const json::value told = json::parse(std::string(std::istreambuf_iterator<char>(file), {}));
  json::object moving = run.at("input_to_decoded_ms").as_object();
  moving.erase("max");
  const auto [width, height] = parse_size(arguments.size);
  const double settled = number(run, "rest_to_settled_ms");
  return {{"data", std::filesystem::path(data).filename().string()},
          {"size", {width, height}},
          {"gesture", arguments.gesture},
          {"moving_ms", std::move(moving)},
          {"fps", run.at("fps")},
          {"settled_ms", settled > 0 ? json::value(settled) : json::value()},  // none came before the lossless one
          {"lossless_ms", run.at("rest_to_lossless_ms")},
          {"moving_size", usual_size(told)},
          {"tetrahedra", run.at("tetrahedra")},
          {"layers", view.layers.size()},
          {"draw_ms", run.at("draw_ms").at("p50")},
          {"encode_ms", run.at("encode_ms").at("p50")},
          {"device", run.at("device")}};
}

void print_hand(const json::object& run) {
  const json::array& size = run.at("moving_size").as_array();
  std::printf(
      "%-28s input to decoded ms p50 %5.0f p95 %5.0f  %5.1f fps at %4dx%-4d  rest to exact %4.0f ms  draw %4.0f ms, %lld "
      "tetrahedra\n",
      run.at("data").as_string().c_str(), number(run.at("moving_ms"), "p50"), number(run.at("moving_ms"), "p95"),
      run.at("fps").to_number<double>(), size.empty() ? 0 : size.at(0).to_number<int>(),
      size.empty() ? 0 : size.at(1).to_number<int>(), run.at("lossless_ms").to_number<double>(),
      run.at("draw_ms").to_number<double>(), static_cast<long long>(run.at("tetrahedra").to_number<std::int64_t>()));
  std::fflush(stdout);
}

void run(const HandArguments& arguments) {
  parse_size(arguments.size);
  json::array runs;
  std::size_t failed = 0;
  for (const std::string& data : arguments.data) {
    try {
      json::object one = measure(arguments, data);
      if (!arguments.json) print_hand(one);
      runs.push_back(std::move(one));
    } catch (const Error& error) {
      if (error.code() == ErrorCode::cancelled || arguments.data.size() == 1) throw;
      ++failed;  // one bad file of many is not a reason to measure none
      std::fprintf(stderr, "isostrata: %s\n", error.what());
      runs.push_back(json::object{{"data", std::filesystem::path(data).filename().string()}, {"error", error.what()}});
    }
  }
  if (arguments.json) print_json(json::object{{"runs", std::move(runs)}, {"threads", thread_count()}, {"simd", simd_level()}});
  if (failed == arguments.data.size()) throw Error(ErrorCode::not_found, "none of the data could be measured");
}

}  // namespace

void add_bench_hand_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand(
      "hand",
      "How quickly pictures follow a hand that turns, or cuts, what a session of each dataset begins with, over loopback");
  auto arguments = std::make_shared<HandArguments>();
  command->add_option("--data", arguments->data, "File or name of analytic data; several may follow")->capture_default_str();
  command->add_option("--gesture", arguments->gesture, "turn the camera, or drag the upper end of the first interval")
      ->check(CLI::IsMember({"turn", "interval"}))
      ->capture_default_str();
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command->add_option("--seconds", arguments->seconds, "How long the hand moves, for each dataset")
      ->check(CLI::Range(0.5, 3600.0))
      ->capture_default_str();
  command->add_option("--renderer", arguments->renderer, "auto, native, raster or compute")
      ->check(CLI::IsMember({"auto", "native", "raster", "compute"}))
      ->capture_default_str();
  command->add_option("--device", arguments->device, "auto, egl:INDEX, egl:UUID, surfaceless or osmesa")->capture_default_str();
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
