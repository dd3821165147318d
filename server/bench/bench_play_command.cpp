// `isostrata bench play`: the steps of a series as pictures, one after the other, by an engine as a session has it.
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

struct PlayArguments {
  std::vector<std::string> data{"cylinder"};
  std::string size = "1280x720";
  int repeat = 3;
  std::size_t most = 100;
  bool json = false;
};

json::object measure(const PlayArguments& arguments, const std::string& data) {
  const auto [width, height] = parse_size(arguments.size);
  std::vector<double> cold, warm;
  std::uint64_t resident = 0;
  std::size_t steps = 0;
  std::int64_t tetrahedra = 0;
  for (int i = 0; i < arguments.repeat; ++i) {
    const ScratchCache cache;
    const std::uint64_t before = resident_bytes();
    BenchEngine engine(data);
    const DatasetFacts facts = engine.open();
    steps = std::min(facts.times.size(), arguments.most);
    Scene scene = engine.first_scene(facts, static_cast<double>(width) / height);
    const auto pass = [&] {
      const Stopwatch watch;
      for (std::size_t step = 0; step < steps; ++step) {
        scene.step = static_cast<int>(step);
        tetrahedra = engine.picture(scene, width, height).tetrahedra;
      }
      return 1000 * static_cast<double>(steps) / watch.elapsed_ms();
    };
    cold.push_back(pass());
    pass();  // what is made beside the pictures is made by then
    warm.push_back(pass());
    const std::uint64_t after = resident_bytes();
    resident = std::max(resident, after - std::min(after, before));
  }
  return {{"data", std::filesystem::path(data).filename().string()},
          {"steps", steps},
          {"steps_per_second", {{"cold", median(cold)}, {"warm", median(warm)}}},
          {"resident_mb", static_cast<double>(resident) / 1e6},
          {"size", {width, height}},
          {"tetrahedra", tetrahedra}};
}

void run(const PlayArguments& arguments) {
  parse_size(arguments.size);
  json::array runs;
  for (const std::string& data : arguments.data) {
    json::object one = measure(arguments, data);
    if (!arguments.json) {
      const json::object& rates = one.at("steps_per_second").as_object();
      std::printf("%-28s %4lld steps: %6.2f a second cold, %6.2f warm; %7.1f MB of memory, %lld tetrahedra in the last\n",
                  one.at("data").as_string().c_str(), static_cast<long long>(one.at("steps").to_number<std::int64_t>()),
                  rates.at("cold").as_double(), rates.at("warm").as_double(), one.at("resident_mb").as_double(),
                  static_cast<long long>(one.at("tetrahedra").as_int64()));
      std::fflush(stdout);
    }
    runs.push_back(std::move(one));
  }
  if (arguments.json) print_json(json::object{{"runs", std::move(runs)}, {"threads", thread_count()}});
}

}  // namespace

void add_bench_play_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand(
      "play", "Steps of a series as pictures, one after the other: steps a second at the first pass (cold) and at the third (warm)");
  auto arguments = std::make_shared<PlayArguments>();
  command->add_option("--data", arguments->data, "File, pattern of a series, or name of analytic data; several may follow")->capture_default_str();
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command->add_option("--repeat", arguments->repeat, "How often each is measured; the median is printed")->check(CLI::Range(1, 100))->capture_default_str();
  command->add_option("--steps", arguments->most, "The most steps to show, from the first")->check(CLI::Range(1, 100000))->capture_default_str();
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
