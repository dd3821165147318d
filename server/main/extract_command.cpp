#include <boost/json.hpp>
#include <charconv>
#include <cstdio>
#include <memory>

#include "base/parallel.h"
#include "base/simd_level.h"
#include "base/stopwatch.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/files/write_mesh.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/layers/extract_layers.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/extract_device.h"
#include "main/json_number.h"
#include "main/mesh_arguments.h"
#include "main/ranks.h"
#include "main/verify_layers.h"

namespace isostrata {
namespace {

struct ExtractArguments : MeshArguments {
  std::string color_by, out, ranks;
  std::vector<std::string> facets;
  ExtractDevice device;
  int compression = WriteOptions{}.compression;
  bool verify = false;
};

struct Timing {
  double load = 0, index = 0, extract = 0, check = 0, write = 0, total = 0;  // ms
  double proof = 0;                                                          // apart: not part of total
};

struct FacetCounts {
  std::int64_t lower = 0, upper = 0, domain = 0, unmatched = 0;
};

/// What is said of a mesh, whoever holds it.
struct MeshFacts {
  const std::vector<IntervalSummary>& summaries;
  std::int64_t cells = 0, active_cells = 0, tetrahedra = 0, points = 0;
  StrictSummary strict;
};

MeshFacts facts_of(const IntervalMesh& mesh) {
  return {mesh.summaries, mesh.cells, mesh.active_cells, static_cast<std::int64_t>(mesh.tetrahedra.size()), static_cast<std::int64_t>(mesh.positions.size()), mesh.strict};
}

FacetCounts count_facets(const IntervalMesh& mesh) {
  FacetCounts counts;
  for (const BoundaryFacet& facet : mesh.facets) {
    counts.lower += facet.label == FacetLabel::lower;
    counts.upper += facet.label == FacetLabel::upper;
    counts.domain += facet.label == FacetLabel::domain;
  }
  counts.unmatched = count_unmatched_facets(mesh, command_task());
  return counts;
}

const char* to_string(TimeMode mode) {
  return mode == TimeMode::spacetime ? "spacetime" : mode == TimeMode::interpolate ? "interpolate" : "step";
}

boost::json::object to_json(const LayerTime& time) {
  boost::json::object out{{"value", time.time}, {"mode", to_string(time.mode)}, {"steps", boost::json::array{time.first}}};
  if (time.second != time.first) out["steps"].as_array().push_back(time.second);
  out["weight"] = time.weight;
  if (time.mode == TimeMode::spacetime) {
    out["simplices"] = time.simplices;
    out["bytes"] = time.bytes;
  }
  return out;
}

boost::json::object to_json(const StrictSummary& strict) {
  return {{"turned_cells", strict.turned_cells},   {"pulled_cells", strict.pulled_cells},
          {"centred_cells", strict.centred_cells}, {"star_cells", strict.star_cells},
          {"tangled_cells", strict.tangled_cells}, {"added_tetrahedra", strict.added_tetrahedra},
          {"added_points", strict.added_points}};
}

boost::json::object to_json(const MeshFacts& mesh, const FacetCounts& facets, const Timing& ms,
                            const std::string& device) {
  boost::json::array intervals;
  for (const IntervalSummary& row : mesh.summaries) {
    intervals.push_back(boost::json::object{{"lower", json_number(row.interval.lower)},
                                            {"upper", json_number(row.interval.upper)},
                                            {"active_cells", row.active_cells},
                                            {"tetrahedra", row.tetrahedra},
                                            {"volume", row.signed_volume},
                                            {"signed_volume", row.signed_volume},
                                            {"absolute_volume", row.volume},
                                            {"inverted", row.inverted}});
    if (row.triangles > 0) {
      intervals.back().as_object().emplace("triangles", row.triangles);
      intervals.back().as_object().emplace("area", row.area);
    }
    if (row.term >= 0) intervals.back().as_object().emplace("term", row.term);
  }
  return {{"cells", mesh.cells},
          {"active_cells", mesh.active_cells},
          {"tetrahedra", mesh.tetrahedra},
          {"points", mesh.points},
          {"unmatched_facets", facets.unmatched},
          {"boundary_facets", boost::json::object{{"lower", facets.lower}, {"upper", facets.upper}, {"domain", facets.domain}}},
          {"intervals", std::move(intervals)},
          {"strict", to_json(mesh.strict)},
          {"ms", boost::json::object{{"load", ms.load},
                                     {"index", ms.index},
                                     {"extract", ms.extract},
                                     {"check", ms.check},
                                     {"write", ms.write},
                                     {"proof", ms.proof},
                                     {"total", ms.total}}},
          {"threads", thread_count()},
          {"simd", simd_level()},
          {"device", device}};
}

/// Of a flat grid.
void print_areas(const IntervalMesh& mesh, const std::string& array, const Timing& ms) {
  std::printf("%s: %lld of %lld cells active, %zu triangles, %zu points\n", array.c_str(), static_cast<long long>(mesh.active_cells),
              static_cast<long long>(mesh.cells), mesh.facets.size(), mesh.positions.size());
  std::printf("%14s %14s %10s %10s %16s\n", "lower", "upper", "cells", "triangles", "area");
  for (const IntervalSummary& row : mesh.summaries)
    std::printf("%14.8g %14.8g %10lld %10lld %16.10g\n", row.interval.lower, row.interval.upper,
                static_cast<long long>(row.active_cells), static_cast<long long>(row.triangles), row.area);
  std::printf("load %.1f ms, extract %.1f ms, write %.1f ms, total %.1f ms on %d threads\n", ms.load, ms.extract, ms.write, ms.total,
              thread_count());
}

void print_text(const MeshFacts& mesh, const std::string& array, const FacetCounts& facets, const Timing& ms) {
  std::printf("%s: %lld of %lld cells active, %lld tetrahedra, %lld points\n", array.c_str(), static_cast<long long>(mesh.active_cells),
              static_cast<long long>(mesh.cells), static_cast<long long>(mesh.tetrahedra), static_cast<long long>(mesh.points));
  std::printf("%14s %14s %10s %10s %16s %16s %8s\n", "lower", "upper", "cells", "tetrahedra", "volume", "absolute volume",
              "inverted");
  for (const IntervalSummary& row : mesh.summaries)
    std::printf("%14.8g %14.8g %10lld %10lld %16.10g %16.10g %8lld%s\n", row.interval.lower, row.interval.upper,
                static_cast<long long>(row.active_cells), static_cast<long long>(row.tetrahedra), row.signed_volume,
                row.volume,
                static_cast<long long>(row.inverted), row.term < 0 ? "" : "  what a term adds");
  std::printf("boundary facets: %lld lower, %lld upper, %lld domain; %lld unmatched\n", static_cast<long long>(facets.lower),
              static_cast<long long>(facets.upper), static_cast<long long>(facets.domain),
              static_cast<long long>(facets.unmatched));
  if (mesh.strict.turned_cells > 0)
    std::printf(
        "strict: of %lld cells with turned tetrahedra %lld pulled from another point, %lld from a point inside, %lld cut around "
        "a "
        "point, %lld tangled and left; %+lld tetrahedra, %lld points\n",
        static_cast<long long>(mesh.strict.turned_cells), static_cast<long long>(mesh.strict.pulled_cells),
        static_cast<long long>(mesh.strict.centred_cells), static_cast<long long>(mesh.strict.star_cells),
        static_cast<long long>(mesh.strict.tangled_cells), static_cast<long long>(mesh.strict.added_tetrahedra),
        static_cast<long long>(mesh.strict.added_points));
  std::printf("load %.1f ms, index %.1f ms, extract %.1f ms, check %.1f ms, write %.1f ms, total %.1f ms on %d threads\n",
              ms.load, ms.index, ms.extract, ms.check, ms.write, ms.total, thread_count());
}

void print_time(const LayerTime& time) {
  if (time.second == time.first)
    std::printf("time %.8g: step %d\n", time.time, time.first);
  else
    std::printf("time %.8g: %.4f of the way from step %d to step %d, %s\n", time.time, time.weight, time.first, time.second,
                to_string(time.mode));
  if (time.mode == TimeMode::spacetime)
    std::printf("%lld 4-simplices in %.1f MB: built in %.1f ms, sliced in %.1f ms\n", static_cast<long long>(time.simplices),
                static_cast<double>(time.bytes) / 1e6, time.build_ms, time.slice_ms);
}

/// "lower", or "lower@2" for that of interval 2.
FacetChoice parse_facet_choice(const std::string& text, std::size_t intervals) {
  const std::size_t at = text.find('@');
  const std::string label = text.substr(0, at);
  FacetChoice choice;
  if (label == "lower")
    choice.label = FacetLabel::lower;
  else if (label == "upper")
    choice.label = FacetLabel::upper;
  else if (label != "domain")
    throw Error(ErrorCode::invalid_argument,
                "facets '" + text + "': expected lower, upper or domain, with @N for interval N only");
  if (at == std::string::npos) return choice;
  std::size_t number = 0;
  const char* const begin = text.data() + at + 1;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, number);
  if (error != std::errc{} || stop != end || number >= intervals)
    throw Error(ErrorCode::invalid_argument,
                "facets '" + text + "': expected the number of an interval after @, 0 to " + std::to_string(intervals - 1));
  choice.interval = static_cast<std::uint16_t>(number);
  return choice;
}

/// Of what looks at the whole mesh ranks do nothing.
void check_for_ranks(const ExtractArguments& arguments) {
  if (arguments.verify) throw Error(ErrorCode::unsupported, "--verify looks at the whole mesh, which no rank has; leave --ranks away");
  if (!arguments.out.empty() && !arguments.out.ends_with(".pvtu"))
    throw Error(ErrorCode::unsupported, arguments.out + ": ranks write a .pvtu, with a piece beside it for each rank");
}

void run_as_rank(SceneRanks& ranks, LayerRequest request, const ExtractArguments& arguments, const WriteOptions& write) {
  check_for_ranks(arguments);
  ranks.configure({.threads = arguments.threads, .region = region_of_arguments()});
  Stopwatch total, stage;
  Timing ms;
  const StepSource steps = step_source(arguments.file);
  open_for(request, steps);
  ms.load = stage.lap_ms();
  const RankedExtraction made = ranks.write_pieces({arguments.file, arguments.file}, steps, request, arguments.out, write, command_task());
  ms.extract = stage.lap_ms();
  ms.total = total.elapsed_ms();
  const MeshFacts mesh{made.summaries, made.cells, made.active_cells, made.tetrahedra, made.points, {}};
  const FacetCounts facets{made.lower_facets, made.upper_facets, made.domain_facets, made.unmatched_facets};
  if (!arguments.json) return print_text(mesh, request.array, facets, ms);
  boost::json::object document = to_json(mesh, facets, ms, "CPU");
  document.erase("strict");
  document["ranks"] = ranks.count();
  print_json(document);
}

void run(ExtractArguments& arguments) {
  if (!arguments.ranks.empty()) {
    check_for_ranks(arguments);
    run_by_ranks(arguments.ranks, arguments.out);
  }
  LayerRequest request = mesh_request(arguments);
  if (request.values == FieldValues::whole) request.carry.push_back("");  // the array itself, once its name is known
  if (!arguments.color_by.empty() && arguments.color_by != arguments.array) request.carry.push_back(arguments.color_by);
  if (!arguments.out.empty() && !ranks_in_use()) check_mesh_path(arguments.out);
  WriteOptions write;
  write.compression = arguments.compression;
  for (const std::string& text : arguments.facets) write.facets.push_back(parse_facet_choice(text, request.intervals.size()));
  if (arguments.threads > 0) set_thread_count(arguments.threads);

  if (ranks_in_use()) return run_as_rank(*ranks_in_use(), request, arguments, write);
  Stopwatch total, stage;
  Timing ms;
  const StepSource open = step_source(arguments.file);
  const StepSource steps = [&](int step, const Task& task) {  // a time between steps opens more of them while extracting
    Stopwatch loading;
    auto dataset = open(step, task);
    ms.load += loading.lap_ms();
    return dataset;
  };
  const std::shared_ptr<const Dataset> dataset = open_for(request, steps);
  if (request.values == FieldValues::whole) request.carry.front() = request.array;
  stage.lap_ms();

  prepare_tables(dataset->grid);
  ms.index = stage.lap_ms();
  const double loaded = ms.load;
  const Layers layers = extract_layers(request, steps, command_task(), {.extractor = device_extractor(arguments.device)});
  const IntervalMesh& mesh = layers.mesh;
  ms.extract = stage.lap_ms() - (ms.load - loaded);
  const FacetCounts facets = count_facets(mesh);
  ms.check = stage.lap_ms();
  if (!arguments.out.empty()) {
    write_mesh(arguments.out, mesh, request.array, layers.carried, write, command_task());
    ms.write = stage.lap_ms();
  }
  ms.total = total.elapsed_ms();

  Proof proof;
  if (arguments.verify) {
    stage.lap_ms();
    proof = prove(request, layers);
    ms.proof = stage.lap_ms();
  }
  if (arguments.json) {
    boost::json::object document = to_json(facts_of(mesh), facets, ms, arguments.device.used);
    document["time"] = to_json(layers.time);
    for (std::size_t i = 0; i < proof.volume_errors.size(); ++i)
      document["intervals"].as_array()[i].as_object()["volume_error"] = proof.volume_errors[i];
    if (arguments.verify) document["partition_error"] = proof.partition ? boost::json::value(proof.partition->error) : nullptr;
    if (layers.time.mode == TimeMode::spacetime) {
      document["ms"].as_object()["build"] = layers.time.build_ms;
      document["ms"].as_object()["slice"] = layers.time.slice_ms;
    }
    print_json(document);
  } else {
    if (layers.dataset->grid.flat())
      print_areas(mesh, request.array, ms);
    else
      print_text(facts_of(mesh), request.array, facets, ms);
    print_time(layers.time);
    print_errors(mesh, proof);
  }
  if (arguments.verify) {
    judge(proof);
    std::fprintf(stderr, "all laws hold%s\n", proof.partition ? "" : " (no partition is defined for combined ranges and times)");
  }
}

}  // namespace

void add_extract_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("extract", "Extracts interval volumes as a mesh of tetrahedra");
  auto arguments = std::make_shared<ExtractArguments>();
  add_mesh_options(*command, *arguments);
  add_device_option(*command, arguments->device);
  command->add_option("--color-by", arguments->color_by, "A further array whose values are written with the mesh");
  command->add_option("--out", arguments->out, "Write the tetrahedra (.vtu; .vtkhdf, which is written faster; .pvtu with --ranks) or their boundary (.ply, .stl)");
  command
      ->add_option("--facets", arguments->facets,
                   "Which of the boundary goes into .ply and .stl: lower, upper, domain, comma-separated; LABEL@N: of interval N "
                   "only, counted from 0 (default: all)")
      ->delimiter(',');
  command->add_option("--compress", arguments->compression, "zlib's level for .vtu; 0: not compressed")
      ->check(CLI::Range(0, 9))
      ->capture_default_str();
  command->add_flag("--verify", arguments->verify,
                    "Check every law that the mesh must keep; exit status 1 and a line for each broken one. Also estimates how far the "
                    "volumes are from those of the interpolated field: hexahedra, wedges and pyramids are cut straight");
  add_ranks_option(*command, arguments->ranks);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace isostrata
