// section: layers cut by a plane, as areas.
#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/parallel.h"
#include "extraction/files/write_mesh.h"
#include "extraction/files/write_vtu.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/measure/section.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/json_number.h"
#include "main/mesh_arguments.h"

namespace isostrata {
namespace {

struct SectionArguments : MeshArguments {
  std::string plane, out;
  std::vector<std::string> of;
};

/// "x,y,z,nx,ny,nz", or "x=VALUE" and so on.
Plane parse_plane(const std::string& text) {
  const auto wrong = [&text]() -> Error {
    return {ErrorCode::invalid_argument, "plane '" + text + "': expected x,y,z,nx,ny,nz, a point and a direction that is not zero, or x=VALUE, y=VALUE or z=VALUE"};
  };
  const auto number = [&](std::string_view part) {
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc{} || end != part.data() + part.size() || !std::isfinite(value)) throw wrong();
    return value;
  };
  Plane plane{};
  if (text.size() > 2 && text[1] == '=' && text[0] >= 'x' && text[0] <= 'z') {
    plane.normal[text[0] - 'x'] = 1;
    plane.point[text[0] - 'x'] = number(std::string_view(text).substr(2));
    return plane;
  }
  std::string_view rest = text;
  for (int i = 0; i < 6; ++i) {
    const std::string_view part = rest.substr(0, i < 5 ? rest.find(',') : rest.size());
    if (i < 5 && part.size() == rest.size()) throw wrong();
    (i < 3 ? plane.point : plane.normal)[i % 3] = number(part);
    rest.remove_prefix(i < 5 ? part.size() + 1 : part.size());
  }
  if (!(length(plane.normal) > 0)) throw wrong();
  return plane;
}

void write_section(const std::filesystem::path& path, const Section& section, const std::string& array) {
  constexpr int kCompression = WriteOptions{}.compression;
  if (path.extension() != ".vtp") return write_mesh(path, section.mesh, array, section.carried, {}, command_task());
  OutputFile out(path, OutputFile::kNoEnd);
  write_vtp(out, section.mesh, array, section.carried, kCompression, command_task());
  out.finish();
}

void run_section(const SectionArguments& arguments) {
  const Plane plane = parse_plane(arguments.plane);
  if (!arguments.out.empty() && !arguments.out.ends_with(".vtp")) check_mesh_path(arguments.out);
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  LayerRequest request = mesh_request(arguments);
  request.carry = arguments.of;
  const StepSource steps = step_source(arguments.file);
  const std::shared_ptr<const Dataset> dataset = open_for(request, steps);
  if (dataset->grid.flat())
    throw Error(ErrorCode::unsupported, dataset->name + ": it has areas and no cells with a volume that a plane could cut; `isostrata info` says what is in it");
  const Layers layers = extract_layers(request, steps, command_task());
  const Section section = section_of(layers.mesh, layers.carried, plane, command_task());
  if (!arguments.out.empty()) write_section(arguments.out, section, request.array);
  if (!arguments.json) {
    std::printf("%14s %14s %16s %10s\n", "lower", "upper", "area", "triangles");
    for (const IntervalSummary& row : section.mesh.summaries)
      std::printf("%14.6g %14.6g %16.10g %10lld\n", row.interval.lower, row.interval.upper, row.area, static_cast<long long>(row.triangles));
    std::printf("%lld unmatched edges\n", static_cast<long long>(section.unmatched_edges));
    return;
  }
  boost::json::array rows;
  for (const IntervalSummary& row : section.mesh.summaries)
    rows.push_back(boost::json::object{{"lower", json_number(row.interval.lower)}, {"upper", json_number(row.interval.upper)}, {"area", row.area}, {"triangles", row.triangles}});
  print_json(boost::json::object{{"layers", std::move(rows)}, {"unmatched_edges", section.unmatched_edges}});
}

}  // namespace

void add_section_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("section", "Cuts layers by a plane: the area of each, and the areas as a mesh");
  const auto arguments = std::make_shared<SectionArguments>();
  add_mesh_options(*command, *arguments);
  command->add_option("--plane", arguments->plane, "x,y,z,nx,ny,nz: a point of the plane and its normal; or x=VALUE, y=VALUE, z=VALUE")->required();
  command->add_option("--of", arguments->of, "An array to carry to the areas; may be repeated")->allow_extra_args(false);
  command->add_option("--out", arguments->out, "The areas as .vtp, .vtu, .vtkhdf, .ply or .stl");
  command->callback([arguments] { run_section(*arguments); });
}

}  // namespace isostrata
