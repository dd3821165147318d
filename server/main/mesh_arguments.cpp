#include "main/mesh_arguments.h"

#include "data/dataset/array_or_first.h"
#include "main/arguments.h"
#include "main/sandbox_option.h"

namespace isostrata {

void add_mesh_options(CLI::App& command, MeshArguments& arguments) {
  add_file_option(command, arguments.file, "A file, or the name of analytic data (torus:64)");
  command.add_option("--array", arguments.array, "The point array (default: the first)");
  command.add_option("--interval", arguments.intervals, "LOWER:UPPER, of which -inf and inf leave an end open; may be repeated")->required()->allow_extra_args(false);
  add_layer_options(command, arguments.layers);
  add_region_options(command);
  command.add_option("--max-memory", arguments.max_memory, "The most bytes that extraction may need (suffixes KB, MB, GB): more is refused before it is taken")
      ->transform(CLI::AsSizeValue(false))
      ->capture_default_str();
  command.add_option("--threads", arguments.threads, "Threads to use (default: all cores)")->check(CLI::Range(0, 4096));
  command.add_flag("--json", arguments.json, "Print one JSON document");
  add_sandbox_option(command);
}

LayerRequest mesh_request(const MeshArguments& arguments) {
  LayerRequest request = layer_request(arguments.layers);
  request.array = arguments.array;
  request.max_bytes = arguments.max_memory;
  request.facets = true;
  for (const std::string& text : arguments.intervals) request.intervals.push_back(parse_interval(text, request.intervals.size()).interval);
  return request;
}

std::shared_ptr<const Dataset> open_for(LayerRequest& request, const StepSource& steps, bool warn) {
  std::shared_ptr<const Dataset> dataset = steps(request.step, command_task());
  request.array = array_or_first(*dataset, request.array).name;
  if (dataset->grid.cell_count() == 0)
    throw Error(ErrorCode::unsupported, dataset->name + ": it has no cells with a volume or an area, so there is nothing to cut; `isostrata info` says what is in it");
  if (warn && !request.time)
    for (const Interval& interval : request.intervals) warn_if_outside(interval, dataset->array(request.array));
  return dataset;
}

}  // namespace isostrata
