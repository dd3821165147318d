#include "extraction/layers/extract_layers.h"

#include "extraction/combine/combine_ranges.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/layers/extract_at_time.h"
#include "extraction/mesh/open_ends.h"

namespace isostrata {
namespace {

const PointArray& find_array(const Dataset& dataset, const std::string& name) {
  if (!name.empty()) return dataset.array(name);
  if (dataset.arrays.empty()) throw Error(ErrorCode::not_found, dataset.name + ": no point array; expected at least one");
  return dataset.arrays.front();
}

void combine_terms(const LayerRequest& request, const Dataset& dataset, const PointArray& array,
                   std::span<const PointArray* const> carry, const LayerAids& aids, Layers& layers, const Task& task) {
  std::vector<ArrayTerm> terms;
  for (const RangeTerm& term : request.terms)
    terms.push_back({term.op, &dataset.array(term.array), with_finite_ends(term.range)});
  const auto extract = [&](const Grid& grid, const PointArray& on, std::span<const Interval> intervals, ExtractOptions options) {
    options.strict = request.triangulation == Triangulation::strict;
    options.ordered = aids.ordered;
    return extract_intervals(grid, on, intervals, options, task);
  };
  Combined combined =
      combine_arrays(dataset.grid, array, request.intervals, terms, carry, extract,
                     {request.facets, request.normals, request.max_bytes}, task);
  layers.mesh = std::move(combined.mesh);
  layers.normals = std::move(combined.normals);
  for (std::size_t i = 0; i < carry.size(); ++i)
    layers.carried.push_back({carry[i]->name, {combined.fields[i + 1].begin(), combined.fields[i + 1].end()}});
}

/// What is not there for areas. Times between the steps of a flat grid are interpolated.
void check_flat(const LayerRequest& request, const Dataset& dataset) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::unsupported, dataset.name + ": its cells have an area and no volume; " + what);
  };
  if (!request.terms.empty()) refuse("ranges of several arrays are combined in cells with a volume only");
  if (request.time && request.time_mode == TimeMode::spacetime)
    refuse("expected the time mode step or interpolate, not spacetime");
}

}  // namespace

Layers extract_layers(const LayerRequest& request, const StepSource& steps, const Task& task, const LayerAids& aids) {
  if (request.time_mode == TimeMode::spacetime)
    if (auto sliced = slice_space_time(request, steps, aids.kept, task)) return std::move(*sliced);
  Layers layers;
  layers.dataset = dataset_at_time(request, steps, layers.time, task);
  const Dataset& dataset = *layers.dataset;
  const PointArray& array = find_array(dataset, request.array);
  if (dataset.grid.flat()) check_flat(request, dataset);
  std::vector<const PointArray*> carry;
  for (const std::string& name : request.carry) carry.push_back(&dataset.array(name));
  ExtractOptions options;
  options.facets = request.facets;
  options.strict = request.triangulation == Triangulation::strict;
  options.max_bytes = request.max_bytes;
  options.bricks = aids.bricks;
  options.ordered = aids.ordered;
  if (!request.terms.empty()) {
    combine_terms(request, dataset, array, carry, aids, layers, task);
    return layers;
  }
  layers.mesh = aids.extractor && !options.strict && !dataset.grid.flat()
                    ? aids.extractor(dataset.grid, array, request.intervals, options, task)
                    : extract_intervals(dataset.grid, array, request.intervals, options, task);
  for (const PointArray* other : carry) layers.carried.push_back({other->name, carry_array(layers.mesh, *other)});
  return layers;
}

}  // namespace isostrata
