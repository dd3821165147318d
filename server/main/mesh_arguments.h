// What the commands share that extract a mesh of layers: extract, section, measure and components.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "main/layer_arguments.h"

namespace isostrata {

struct MeshArguments {
  std::string file, array;
  std::vector<std::string> intervals;
  LayerArguments layers;
  std::uint64_t max_memory = LayerRequest{}.max_bytes;
  int threads = 0;
  bool json = false;
};

/// Adds FILE, --array, --interval, the options of layers and regions, --max-memory, --threads, --json and --sandbox. `arguments` must outlive the command.
void add_mesh_options(CLI::App& command, MeshArguments& arguments);

/// The request, whose array need not be named yet.
LayerRequest mesh_request(const MeshArguments& arguments);

/// Opens the request's step and names its array. Throws not_found of the array, unsupported of a dataset without cells. `warn`: a line on standard error for each
/// interval in which none of the array's values lie.
std::shared_ptr<const Dataset> open_for(LayerRequest& request, const StepSource& steps, bool warn = true);

}  // namespace isostrata
