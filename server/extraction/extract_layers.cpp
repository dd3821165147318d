#include "extraction/extract_layers.h"

#include "extraction/extract_at_time.h"
#include "extraction/extract_intervals.h"

namespace isostrata {
namespace {

const PointArray& find_array(const Dataset& dataset, const std::string& name) {
  if (!name.empty()) return dataset.array(name);
  if (dataset.arrays.empty()) throw Error(ErrorCode::not_found, dataset.name + ": no point array; expected at least one");
  return dataset.arrays.front();
}

}  // namespace

Layers extract_layers(const LayerRequest& request, const StepSource& steps, const Task& task, const LayerAids& aids) {
  if (request.time_mode == TimeMode::spacetime)
    if (auto sliced = slice_space_time(request, steps, aids.kept, task)) return std::move(*sliced);
  if (request.triangulation == Triangulation::strict)
    throw Error(ErrorCode::unsupported, "the strict triangulation cannot be extracted yet");
  if (!request.terms.empty()) throw Error(ErrorCode::unsupported, "ranges cannot be combined yet");
  Layers layers;
  layers.dataset = dataset_at_time(request, steps, layers.time, task);
  const Dataset& dataset = *layers.dataset;
  const PointArray& array = find_array(dataset, request.array);
  std::vector<const PointArray*> carry;
  for (const std::string& name : request.carry) carry.push_back(&dataset.array(name));
  ExtractOptions options;
  options.facets = request.facets;
  options.max_bytes = request.max_bytes;
  layers.mesh = aids.extractor ? aids.extractor(dataset.grid, array, request.intervals, options, task)
                          : extract_intervals(dataset.grid, array, request.intervals, options, task);
  for (const PointArray* other : carry) layers.carried.push_back({other->name, carry_array(layers.mesh, *other)});
  return layers;
}

}  // namespace isostrata
