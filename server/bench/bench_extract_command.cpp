#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>

#include "base/parallel.h"
#include "base/simd_level.h"
#include "base/stopwatch.h"
#include "bench/bench_device.h"
#include "bench/bench_sums.h"
#include "bench/commands.h"
#include "bench/usual_interval.h"
#include "data/dataset/array_or_first.h"
#include "data/values/read_once.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/bricks/minmax_bricks.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/unstructured/ordered_memory.h"
#include "main/arguments.h"

namespace isostrata {
namespace {

struct ExtractArguments {
  std::vector<std::string> data{"torus:256"};
  std::string array, interval;
  std::string device = "cpu";
  bool as_bytes = false;
  int repeat = 9;
  int threads = 0;
  bool json = false;
};

/// The upper end of the interval moves back and forth by 1 % of the array's range, as a slider does. Medians.
struct DragRun {
  double index_ms = 0;          // to measure the bricks' ranges, once for an array; in every extraction above
  double records_ms = 0;        // all active bricks anew, with the ranges at hand
  double moved_records_ms = 0;  // only the bricks whose range meets the change
  double moved_mesh_ms = 0;     // that, and the whole mesh written anew: what the server does
  std::uint64_t index_bytes = 0, records_bytes = 0;
  std::size_t bricks = 0, taken_over = 0;  // active ones; those that were not read again
};

/// Tetrahedra with their layout kept, the upper end moving likewise.
struct LayoutRun {
  double make_ms = 0;   // the layout, once for a grid
  double array_ms = 0;  // an array in it, once, with an extraction
  Spread ms;            // the mesh
  std::uint64_t bytes = 0;  // of layout and array
};

struct ExtractRun {
  std::string data, array;
  Interval interval;
  std::int64_t cells = 0, active_cells = 0, tetrahedra = 0;
  Spread ms;
  double read_floor_ms = 0;
  std::uint64_t mesh_bytes = 0;
  std::optional<DragRun> drag;      // of structured grids
  std::optional<LayoutRun> layout;  // of grids of tetrahedra
};

std::string cpu_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) {
      const auto at = line.find(": ");
      if (at != std::string::npos) return line.substr(at + 2);
    }
  return "unknown";
}

std::uint64_t bytes_of(const IntervalMesh& mesh) {
  const auto bytes = [](const auto& array) { return static_cast<std::uint64_t>(array.size() * sizeof(array[0])); };
  return bytes(mesh.positions) + bytes(mesh.origins) + bytes(mesh.values) + bytes(mesh.tetrahedra) +
         bytes(mesh.tetrahedron_interval) + bytes(mesh.cell_runs);
}

DragRun measure_drag(const Grid& grid, const PointArray& array, Interval interval, int repeat, ExtractOptions options) {
  const Task quiet;
  DragRun drag;
  const double step = 0.01 * (array.upper - array.lower);
  BrickMemory memory;
  options.bricks = &memory;
  extract_intervals(grid, array, {&interval, 1}, options, quiet);
  std::vector<double> index_ms, records_ms, moved_records_ms, moved_mesh_ms;
  std::optional<ActiveBricks> last;
  for (int i = 0; i < repeat; ++i) {
    command_task().check();
    Interval moved = interval;
    moved.upper += i % 2 ? 0 : step;
    const IsoRules rules({&moved, 1});
    Stopwatch stopwatch;
    const MinMaxBricks ranges(grid, array, quiet);
    index_ms.push_back(stopwatch.lap_ms());
    ActiveBricks all(grid, array, ranges, rules, options.max_bytes, quiet);
    records_ms.push_back(stopwatch.lap_ms());
    if (!last) last.emplace(grid, array, ranges, IsoRules({&interval, 1}), options.max_bytes, quiet);
    stopwatch.lap_ms();
    ActiveBricks after_move(grid, array, ranges, rules, options.max_bytes, quiet, &*last);
    moved_records_ms.push_back(stopwatch.lap_ms());
    extract_intervals(grid, array, {&moved, 1}, options, quiet);
    moved_mesh_ms.push_back(stopwatch.lap_ms());
    drag.index_bytes = ranges.bytes();
    drag.records_bytes = after_move.bytes();
    drag.bricks = after_move.bricks().size();
    drag.taken_over = after_move.taken_over();
    last = std::move(after_move);
  }
  drag.index_ms = median(index_ms);
  drag.records_ms = median(records_ms);
  drag.moved_records_ms = median(moved_records_ms);
  drag.moved_mesh_ms = median(moved_mesh_ms);
  return drag;
}

std::optional<LayoutRun> measure_layout(const Grid& grid, const PointArray& array, const Interval& interval, int repeat,
                                        ExtractOptions options) {
  const Task quiet;
  OrderedMemory memory(options.max_bytes);
  options.ordered = &memory;
  LayoutRun run;
  Stopwatch stopwatch;
  memory.make(grid, command_task());
  run.make_ms = stopwatch.lap_ms();
  if (memory.bytes() == 0) return std::nullopt;
  extract_intervals(grid, array, {&interval, 1}, options, quiet);
  run.array_ms = stopwatch.lap_ms();
  run.bytes = memory.bytes();
  std::vector<double> ms;
  const double step = 0.01 * (array.upper - array.lower);
  for (int i = 0; i < repeat; ++i) {
    command_task().check();
    Interval moved = interval;
    moved.upper += i % 2 ? 0 : step;
    stopwatch.lap_ms();
    const IntervalMesh mesh = extract_intervals(grid, array, {&moved, 1}, options, quiet);
    ms.push_back(stopwatch.lap_ms());
  }
  run.ms = spread_of(std::move(ms));
  return run;
}

ExtractRun measure(const std::string& data, const ExtractArguments& arguments) {
  const std::shared_ptr<const Dataset> dataset = open_argument(data);
  if (dataset->arrays.empty()) throw Error(ErrorCode::not_found, data + ": no point array; expected at least one");
  const PointArray& array = arguments.array.empty() ? dataset->arrays.front() : dataset->array(arguments.array);
  ExtractRun run;
  run.data = data;
  run.array = array.name;
  run.interval = arguments.interval.empty() ? usual_interval(data, array) : parse_interval(arguments.interval, 0).interval;
  prepare_tables(dataset->grid);

  const Task quiet;
  ExtractOptions options;  // the mesh itself: positions, origins, tetrahedra, their intervals and cells
  options.values = options.measure = false;
  std::vector<double> ms, floor_ms;
  for (int i = 0; i < arguments.repeat; ++i) {
    command_task().check();
    Stopwatch stopwatch;
    read_once(array);
    floor_ms.push_back(stopwatch.lap_ms());
    const IntervalMesh mesh = extract_intervals(dataset->grid, array, {&run.interval, 1}, options, quiet);
    ms.push_back(stopwatch.lap_ms());
    run.cells = mesh.cells;
    run.active_cells = mesh.active_cells;
    run.tetrahedra = static_cast<std::int64_t>(mesh.tetrahedra.size());
    run.mesh_bytes = bytes_of(mesh);
  }
  if (dataset->grid.structured() && dataset->grid.cell_count() > 0)
    run.drag = measure_drag(dataset->grid, array, run.interval, arguments.repeat, options);
  if (!dataset->grid.structured()) run.layout = measure_layout(dataset->grid, array, run.interval, arguments.repeat, options);
  run.ms = spread_of(std::move(ms));
  run.read_floor_ms = *std::min_element(floor_ms.begin(), floor_ms.end());
  return run;
}

boost::json::value to_json(const DragRun& drag) {
  return boost::json::object{{"index_ms", drag.index_ms},
                             {"records_ms", drag.records_ms},
                             {"moved_records_ms", drag.moved_records_ms},
                             {"moved_mesh_ms", drag.moved_mesh_ms},
                             {"index_bytes", drag.index_bytes},
                             {"records_bytes", drag.records_bytes},
                             {"bricks", drag.bricks},
                             {"bricks_taken_over", drag.taken_over}};
}

boost::json::value to_json(const LayoutRun& layout) {
  return boost::json::object{
      {"make_ms", layout.make_ms},
      {"first_ms", layout.array_ms},
      {"ms", to_json(layout.ms)},
      {"bytes", layout.bytes}};
}

boost::json::object to_json(const ExtractRun& run) {
  return {{"data", run.data},
          {"array", run.array},
          {"interval", boost::json::array{run.interval.lower, run.interval.upper}},
          {"cells", run.cells},
          {"active_cells", run.active_cells},
          {"tetrahedra", run.tetrahedra},
          {"ms", to_json(run.ms)},
          {"read_floor_ms", run.read_floor_ms},
          {"mesh_bytes", run.mesh_bytes},
          {"drag", run.drag ? to_json(*run.drag) : boost::json::value()},
          {"layout", run.layout ? to_json(*run.layout) : boost::json::value()}};
}

void print_text(const ExtractRun& run) {
  std::printf(
      "%s, %s %g:%g: %lld of %lld cells, %lld tetrahedra; min %.2f, median %.2f, max %.2f ms; reading the array once %.2f ms\n",
      run.data.c_str(), run.array.c_str(), run.interval.lower, run.interval.upper, static_cast<long long>(run.active_cells),
      static_cast<long long>(run.cells), static_cast<long long>(run.tetrahedra), run.ms.min, run.ms.median, run.ms.max,
      run.read_floor_ms);
  if (run.layout)
    std::printf(
        "  with the tetrahedra laid out (%.0f ms once, %.1f MB), upper end moved by 1 %% of the range: min %.2f, median %.2f, max %.2f "
        "ms; the first with a new array %.2f ms\n",
        run.layout->make_ms, static_cast<double>(run.layout->bytes) / 1e6, run.layout->ms.min, run.layout->ms.median,
        run.layout->ms.max, run.layout->array_ms);
  if (!run.drag) return;
  const DragRun& drag = *run.drag;
  std::printf(
      "  of these the bricks' ranges %.2f ms; mesh %.1f MB, ranges %.2f MB, cell records %.1f MB\n"
      "  upper end moved by 1 %% of the range: cell records %.2f ms (%zu of %zu bricks taken over; all anew %.2f ms), with the "
      "mesh %.2f ms\n",
      drag.index_ms, static_cast<double>(run.mesh_bytes) / 1e6, static_cast<double>(drag.index_bytes) / 1e6,
      static_cast<double>(drag.records_bytes) / 1e6, drag.moved_records_ms, drag.taken_over, drag.bricks, drag.records_ms,
      drag.moved_mesh_ms);
}

DeviceRun measure_device(const std::string& data, const ExtractArguments& arguments) {
  const std::shared_ptr<const Dataset> dataset = open_argument(data);
  const PointArray& array = array_or_first(*dataset, arguments.array);
  const Interval interval =
      arguments.interval.empty() ? usual_interval(data, array) : parse_interval(arguments.interval, 0).interval;
  return measure_on_device(arguments.device, data, dataset->grid, array, interval, arguments.as_bytes, arguments.repeat);
}

void run(const ExtractArguments& arguments) {
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  boost::json::array runs;
  const bool on_device = arguments.device != "cpu";
  if (arguments.as_bytes && !on_device)
    throw Error(ErrorCode::invalid_argument, "--as-bytes measures a device; expected --device, too");
  for (const std::string& data : arguments.data) {
    if (on_device) {
      const DeviceRun one = measure_device(data, arguments);
      if (arguments.json)
        runs.push_back(to_json(one));
      else
        print_text(one);
      continue;
    }
    const ExtractRun one = measure(data, arguments);
    if (arguments.json)
      runs.push_back(to_json(one));
    else
      print_text(one);
  }
  const std::string cpu = cpu_name();
  if (arguments.json)
    print_json(boost::json::object{{"runs", runs}, {"threads", thread_count()}, {"simd", simd_level()}, {"cpu", cpu}});
  else
    std::printf("%d threads, %s, %s\n", thread_count(), simd_level().c_str(), cpu.c_str());
}

}  // namespace

void add_bench_extract_command(CLI::App& bench) {
  CLI::App* command = bench.add_subcommand("extract", "Times extraction, with the time to read the array once beside it");
  auto arguments = std::make_shared<ExtractArguments>();
  command->add_option("--data", arguments->data, "A file or the name of analytic data; may be repeated")
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_option("--array", arguments->array, "The point array to extract on (default: the first)");
  command->add_option("--interval", arguments->interval, "LOWER:UPPER (default: a thin layer)");
  command
      ->add_option("--device", arguments->device,
                   "cpu, or what extracts instead: auto, egl:INDEX, egl:UUID, surfaceless or osmesa; sending the data there is "
                   "timed apart")
      ->capture_default_str();
  command->add_flag("--as-bytes", arguments->as_bytes, "On a device: scale the array to 0..255 first, and the interval with it");
  command->add_option("--repeat", arguments->repeat, "Runs of each")->check(CLI::Range(1, 100000))->capture_default_str();
  command->add_option("--threads", arguments->threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
