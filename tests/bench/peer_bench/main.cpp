// isostrata-peer-bench: ours and VTK's on the same data in one run.
#include <CLI/CLI.hpp>
#include <boost/json.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>

#include "base/error.h"
#include "base/parallel.h"
#include "base/simd_level.h"
#include "extract_bench.h"
#include "main/simd_option.h"
#include "paraview_peer.h"
#include "read_bench.h"
#include "render_bench.h"
#include "vtk_threads.h"

namespace {

using namespace isostrata;
using namespace isostrata::peers;

Interval parse_ends(const std::string& text) {
  double lower = 0, upper = 0;
  int end = 0;
  if (std::sscanf(text.c_str(), "%lf:%lf%n", &lower, &upper, &end) != 2 || end != static_cast<int>(text.size()) ||
      !(lower < upper))
    throw Error(ErrorCode::invalid_argument, "interval '" + text + "': expected LOWER:UPPER, lower less than upper");
  return {lower, upper};
}

std::string cpu_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (const auto at = line.find(": "); line.starts_with("model name") && at != std::string::npos) return line.substr(at + 2);
  return "unknown";
}

constexpr const char* kIncluded =
    "ours: from grid and array to indexed, conforming tetrahedra with points, origins, intervals and cells; the interval tables, "
    "made once per process in 0.1 s, are not in it. The peer: from the same arrays, not copied, to vtkUnstructuredGrid";

/// What ends a report, whose rows have been printed or are in `runs`. `included` says what a time holds.
template <class Report>
void finish_report(const Report& report, bool json, boost::json::array runs, const char* included) {
  if (!json) {
    for (const std::string& what : report.left_out) std::printf("left out: %s\n", what.c_str());
    std::printf("%s; %s; ours: %d threads, %s\n%s\n", cpu_name().c_str(), report.vtk.c_str(), thread_count(), simd_level().c_str(),
                included);
    return;
  }
  boost::json::array left_out;
  for (const std::string& what : report.left_out) left_out.push_back(boost::json::string(what));
  const std::string text = boost::json::serialize(boost::json::object{{"runs", std::move(runs)},
                                                                      {"left_out", std::move(left_out)},
                                                                      {"threads", thread_count()},
                                                                      {"simd", simd_level()},
                                                                      {"vtk", report.vtk},
                                                                      {"cpu", cpu_name()},
                                                                      {"included", included}});
  std::printf("%s\n", text.c_str());
}

struct ExtractArguments {
  ExtractBenchOptions options;
  std::string interval;
  bool json = false;
};

void run_extract(ExtractArguments& arguments) {
  if (!arguments.interval.empty()) arguments.options.interval = parse_ends(arguments.interval);
  if (!paraview_found() || !std::filesystem::exists(arguments.options.paraview_script)) arguments.options.paraview_script.clear();
  const ExtractBenchReport report = run_extract_bench(arguments.options);
  boost::json::array runs;
  if (arguments.json)
    for (const Row& row : report.rows) runs.push_back(to_json(row));
  else
    print_text(report.rows);
  finish_report(report, arguments.json, std::move(runs), kIncluded);
}

void add_extract(CLI::App& app) {
  CLI::App* command = app.add_subcommand("extract", "Interval volumes: our extraction, and two clips of VTK's");
  auto arguments = std::make_shared<ExtractArguments>();
  ExtractBenchOptions& options = arguments->options;
  options.paraview_script = ISOSTRATA_SOURCE_DIR "/tests/bench/paraview_isovolume.py";
  command
      ->add_option("--data", options.data,
                   "A file, the name of analytic data, or torus-u8:N; may be repeated (default: the standard rows)")
      ->allow_extra_args(false);
  command->add_option("--array", options.array, "The point array of --data (default: the first)");
  CLI::Option* interval = command->add_option("--interval", arguments->interval, "LOWER:UPPER for --data (default: by --share)");
  command->add_option("--share", options.share, "For --data: the share of its cells that the interval passes through")
      ->check(CLI::Range(1e-6, 1.0))
      ->capture_default_str()
      ->excludes(interval);
  command->add_flag("--full", options.full, "All repeats of the long rows, and ParaView's IsoVolume where pvpython is found");
  command->add_option("--threads", options.threads, "Threads for either side")->check(CLI::Range(1, 4096))->capture_default_str();
  command->add_option("--paraview-script", options.paraview_script, "What --full runs in pvpython")->capture_default_str();
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run_extract(*arguments); });
}

constexpr const char* kFrame =
    "a frame: from a new camera to 8 bits a channel in memory, order, projection and readback included; what is derived once "
    "from the mesh "
    "(buffers, shaders, neighbours) is not. Difference: of colours, in steps of 8 bits, over the pixels that either side covers";

struct RenderArguments {
  RenderBenchOptions options;
  std::string interval;
  bool json = false;
};

void run_render(RenderArguments& arguments) {
  if (!arguments.interval.empty()) arguments.options.interval = parse_ends(arguments.interval);
  boost::json::array runs;
  const RenderBenchReport report = run_render_bench(arguments.options, [&](const RenderRow& row) {
    if (arguments.json)
      runs.push_back(to_json(row));
    else
      print_text(row);
  });
  finish_report(report, arguments.json, std::move(runs), kFrame);
}

void add_render(CLI::App& app) {
  CLI::App* command = app.add_subcommand("render", "Frames of a turning camera: ours, and VTK's mappers for tetrahedra");
  auto arguments = std::make_shared<RenderArguments>();
  RenderBenchOptions& options = arguments->options;
  command->add_option("--data", options.data, "A file or the name of analytic data; may be repeated (default: the standard rows)")
      ->allow_extra_args(false);
  command->add_option("--interval", arguments->interval, "LOWER:UPPER for --data (default: the middle tenth of the range)");
  command->add_option("--size", options.sizes, "Of the square picture; may be repeated (default: 512 and 1024)")
      ->check(CLI::Range(1, 16384))
      ->allow_extra_args(false);
  command->add_option("--peer", options.peers, "pt, bunyk, zsweep or raster; may be repeated (default: as the rows need)")
      ->check(CLI::IsMember({"pt", "bunyk", "zsweep", "raster"}))
      ->allow_extra_args(false);
  command->add_option("--renderer", options.renderer, "Ours: auto, native, raster or compute")
      ->check(CLI::IsMember({"auto", "native", "raster", "compute"}))
      ->capture_default_str();
  command->add_option("--seconds", options.seconds, "For our frames of one row, before and after the peer's")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  command->add_flag("--full", options.full, "The long rows too, and more frames of each");
  command->add_option("--threads", options.threads, "Threads for either side")->check(CLI::Range(1, 4096))->capture_default_str();
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] { run_render(*arguments); });
}

struct MemoryArguments {
  std::string side, data, array, interval;
  int threads = 2;
};

void add_peak_memory(CLI::App& app) {
  CLI::App* command = app.add_subcommand("peak-memory", "One side's work once: prints its peak memory and the data's, in bytes");
  auto arguments = std::make_shared<MemoryArguments>();
  command->add_option("SIDE", arguments->side, "ours or vtk")->required()->check(CLI::IsMember({"ours", "vtk"}));
  command->add_option("DATA", arguments->data, "As --data of extract")->required();
  command->add_option("--array", arguments->array, "The point array (default: the first)");
  command->add_option("--interval", arguments->interval, "LOWER:UPPER")->required();
  command->add_option("--threads", arguments->threads, "Threads")->check(CLI::Range(1, 4096))->capture_default_str();
  command->callback([arguments] {
    print_peak_memory(arguments->side == "ours" ? Side::ours : Side::vtk, arguments->data, arguments->array,
                      parse_ends(arguments->interval), arguments->threads);
  });
}

constexpr const char* kOpened =
    "from the file's name to all values with their ranges, of the first step, each in a new process; the kernel's cache of files is left as it is. Held: anonymous memory while the "
    "data is there. At most: the largest resident size of a process that took part, mapped files included";

boost::json::object to_json(const ReadRow& row) {
  const auto cost = [](const ReadCost& of) { return boost::json::object{{"ms", of.ms}, {"held_bytes", of.held_bytes}, {"peak_bytes", of.peak_bytes}}; };
  return {{"data", std::filesystem::path(row.file).filename().string()}, {"bytes", row.bytes}, {"vtk", cost(row.vtk)}, {"cold", cost(row.cold)}, {"kept", cost(row.kept)}};
}

void add_read(CLI::App& app) {
  CLI::App* command = app.add_subcommand("read", "Opening files: ours, with nothing kept and again, and VTK's readers");
  struct Arguments {
    ReadBenchOptions options;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  command->add_option("--data", arguments->options.files, "A file; several may follow")->required()->check(CLI::ExistingFile);
  command->add_option("--repeat", arguments->options.repeat, "How often each is measured, in turns; medians are told")->check(CLI::Range(1, 100))->capture_default_str();
  command->add_option("--threads", arguments->options.threads, "Threads for either side")->check(CLI::Range(1, 4096))->capture_default_str();
  command->add_flag("--json", arguments->json, "Print one JSON document");
  command->callback([arguments] {
    struct Report {
      std::string vtk;
      std::vector<std::string> left_out;
    } report{prepare_vtk(arguments->options.threads), {}};
    boost::json::array runs;
    run_read_bench(arguments->options, [&](const ReadRow& row) { arguments->json ? runs.push_back(to_json(row)) : print_text(row); });
    finish_report(report, arguments->json, std::move(runs), kOpened);
  });
}

void add_read_once(CLI::App& app) {
  struct Arguments {
    std::string who, file, cache;
    int threads = 2;
  };
  CLI::App* command = app.add_subcommand("read-once", "One side's opening once: prints ms, and bytes held and at most");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("SIDE", arguments->who, "ours or vtk")->required()->check(CLI::IsMember({"ours", "vtk"}));
  command->add_option("FILE", arguments->file, "What to open")->required();
  command->add_option("--cache", arguments->cache, "Folder in which ours keeps what it read (default: nothing is kept)");
  command->add_option("--threads", arguments->threads, "Threads")->check(CLI::Range(1, 4096))->capture_default_str();
  command->callback([arguments] { print_read_cost(arguments->who, arguments->file, arguments->cache, arguments->threads); });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Isostrata beside its peers, on the same data in one run"};
  app.require_subcommand(1);
  add_extract(app);
  add_render(app);
  add_peak_memory(app);
  add_read(app);
  add_read_once(app);
  for (CLI::App* command : app.get_subcommands({})) add_simd_option(*command);
  try {
    use_simd_level_of_environment();
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "isostrata-peer-bench: out of memory\n");
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata-peer-bench: %s\n", error.what());
    return 1;
  }
  return 0;
}
