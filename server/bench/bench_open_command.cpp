// `isostrata bench open`: from the name of a file to the first picture of it, by an engine as a session has it.
#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "bench/bench_engine.h"
#include "bench/bench_sums.h"
#include "bench/commands.h"
#include "main/arguments.h"
#include "main/picture_arguments.h"

namespace isostrata {
namespace {

namespace json = boost::json;

struct OpenArguments {
  std::vector<std::string> data{"torus"};
  std::string size = "1280x720";
  int repeat = 3;
  bool json = false;
};

struct Opened {
  double ms = 0;        // to the first picture, which is of every n-th point where the grid is large
  double whole_ms = 0;  // to that of all points
  double opened_ms = 0, extract_ms = 0, draw_ms = 0;
  int point_stride = 1;
  std::int64_t tetrahedra = 0;
  std::uint64_t resident = 0;
};

Opened open_once(const std::string& data, int width, int height) {
  const std::uint64_t before = resident_bytes();
  const Stopwatch watch;
  BenchEngine engine(data);
  const DatasetFacts facts = engine.open();
  Opened opened;
  opened.opened_ms = watch.elapsed_ms();
  const FrameReady frame = engine.picture(engine.first_scene(facts, static_cast<double>(width) / height), width, height, [&](const FrameReady& first) {
    if (opened.ms == 0) opened.ms = watch.elapsed_ms(), opened.point_stride = first.point_stride;
  });
  opened.whole_ms = watch.elapsed_ms();
  if (opened.ms == 0) opened.ms = opened.whole_ms;
  opened.extract_ms = frame.stages.extract_ms;
  opened.draw_ms = frame.stages.order_ms + frame.stages.draw_ms;
  opened.tetrahedra = frame.tetrahedra;
  const std::uint64_t after = resident_bytes();
  opened.resident = after - std::min(after, before);
  return opened;
}

json::object measure(const OpenArguments& arguments, const std::string& data) {
  const auto [width, height] = parse_size(arguments.size);
  std::vector<double> cold, warm, whole_cold, whole_warm;
  Opened first, again;
  std::uint64_t written = 0;
  for (int i = 0; i < arguments.repeat; ++i) {
    const ScratchCache cache;
    first = open_once(data, width, height);
    cold.push_back(first.ms);
    whole_cold.push_back(first.whole_ms);
    written = std::max(written, cache.bytes());
    again = open_once(data, width, height);
    warm.push_back(again.ms);
    whole_warm.push_back(again.whole_ms);
  }
  return {{"data", std::filesystem::path(data).filename().string()},
          {"bytes", source_bytes(data)},
          {"cold_ms", median(cold)},
          {"warm_ms", median(warm)},
          {"point_stride", first.point_stride},
          {"all_points_ms", {{"cold", median(whole_cold)}, {"warm", median(whole_warm)}}},
          {"resident_mb", static_cast<double>(std::max(first.resident, again.resident)) / 1e6},
          {"temporary_mb", static_cast<double>(written) / 1e6},
          {"size", {width, height}},
          {"tetrahedra", first.tetrahedra},
          {"last_ms",
           {{"cold", {{"open", first.opened_ms}, {"extract", first.extract_ms}, {"draw", first.draw_ms}}},
            {"warm", {{"open", again.opened_ms}, {"extract", again.extract_ms}, {"draw", again.draw_ms}}}}}};
}

void run(const OpenArguments& arguments) {
  parse_size(arguments.size);
  json::array runs;
  for (const std::string& data : arguments.data) {
    json::object one = measure(arguments, data);
    if (!arguments.json) {
      std::printf("%-28s first picture %7.0f ms cold, %6.0f ms kept", one.at("data").as_string().c_str(), one.at("cold_ms").as_double(),
                  one.at("warm_ms").as_double());
      if (const auto n = one.at("point_stride").as_int64(); n > 1)
        std::printf(" (of one point in %lld along each axis; of all %.0f and %.0f ms)", static_cast<long long>(n),
                    one.at("all_points_ms").at("cold").as_double(), one.at("all_points_ms").at("warm").as_double());
      std::printf("; %7.1f MB of memory, %8.1f MB written, %lld tetrahedra\n", one.at("resident_mb").as_double(), one.at("temporary_mb").as_double(), static_cast<long long>(one.at("tetrahedra").as_int64()));
      std::fflush(stdout);
    }
    runs.push_back(std::move(one));
  }
  if (arguments.json) print_json(json::object{{"runs", std::move(runs)}, {"threads", thread_count()}});
}

}  // namespace

void add_bench_open_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand(
      "open",
      "From a file's name to its first picture, without and with what is kept of it between runs (the kernel's cache of files is left as it is)");
  auto arguments = std::make_shared<OpenArguments>();
  command->add_option("--data", arguments->data, "File, pattern of a series, or name of analytic data; several may follow")->capture_default_str();
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command->add_option("--repeat", arguments->repeat, "How often each is measured; the median is printed")->check(CLI::Range(1, 100))->capture_default_str();
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
