#include "extraction/layers/extract_layers.h"

#include "data/dataset/array_or_first.h"
#include "data/derived/nearest_points.h"
#include "extraction/combine/combine_ranges.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/intervals/extract_whole.h"
#include "extraction/layers/extract_at_time.h"
#include "extraction/mesh/open_ends.h"

namespace isostrata {
namespace {

void combine_terms(const LayerRequest& request, const Dataset& dataset, const PointArray& array,
                   std::span<const PointArray* const> carry, const LayerAids& aids, Layers& layers, const Task& task) {
  std::vector<ArrayTerm> terms;
  for (const RangeTerm& term : request.terms)
    terms.push_back({term.op, &dataset.array(term.array), with_finite_ends(term.range)});
  const auto extract = [&](const Grid& grid, const PointArray& on, std::span<const Interval> intervals, ExtractOptions options) {
    options.strict = request.triangulation == Triangulation::strict;
    options.ordered = aids.ordered;
    options.faces = aids.faces;
    return extract_intervals(grid, on, intervals, options, task);
  };
  Combined combined =
      combine_arrays(dataset.grid, array, request.intervals, terms, carry, extract,
                     {request.facets, request.normals, request.body_normals, request.max_bytes}, task);
  layers.mesh = std::move(combined.mesh);
  layers.normals = std::move(combined.normals);
  layers.body_normals = std::move(combined.body_normals);
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

void check_whole(const LayerRequest& request) {
  const auto refuse = [](const std::string& what) { throw Error(ErrorCode::unsupported, "whole values: " + what); };
  if (!request.terms.empty()) refuse("they are not combined with ranges of other arrays; expected interpolated values, or no such range");
  if (request.time && request.time_mode != TimeMode::step) refuse("there are none between two steps; expected the time mode step");
  if (request.triangulation == Triangulation::strict) refuse("cells are split by the table; expected the triangulation table");
}

Layers extract_whole_layers(const LayerRequest& request, Layers layers, const Task& task) {
  const PointArray* array = &array_or_first(*layers.dataset, request.array);
  if (!array->cells) {
    if (array->association == Association::cell_averaged)
      throw Error(ErrorCode::unsupported, layers.dataset->name + ": array '" + array->name + "' is of cells that this part of the grid does not have as they are; "
                                              "expected the grid without a stride");
    std::vector<std::string> names{array->name};
    names.insert(names.end(), request.carry.begin(), request.carry.end());
    layers.dataset = nearest_point_cells(layers.dataset, names, request.max_bytes, task);
    array = &layers.dataset->array(array->name);
  }
  ExtractOptions options;
  options.facets = request.facets;
  options.tetrahedra = request.tetrahedra;
  options.max_bytes = request.max_bytes;
  layers.mesh = extract_whole(layers.dataset->grid, *array->cells, request.intervals, options, task);
  for (const std::string& name : request.carry) {
    const PointArray& other = layers.dataset->array(name);
    if (other.cells)
      layers.carried.push_back({other.name, values_in_cells(layers.mesh, *other.cells), true});
    else
      layers.carried.push_back({other.name, carry_array(layers.mesh, other)});
  }
  return layers;
}

}  // namespace

Layers extract_layers(const LayerRequest& request, const StepSource& steps, const Task& task, const LayerAids& aids) {
  if (request.values == FieldValues::whole) check_whole(request);
  if (request.time_mode == TimeMode::spacetime)
    if (auto sliced = slice_space_time(request, steps, aids.kept, task)) return std::move(*sliced);
  Layers layers;
  layers.dataset = dataset_at_time(request, steps, layers.time, task);
  if (request.values == FieldValues::whole) return extract_whole_layers(request, std::move(layers), task);
  const Dataset& dataset = *layers.dataset;
  const PointArray& array = array_or_first(dataset, request.array);
  if (dataset.grid.flat()) check_flat(request, dataset);
  std::vector<const PointArray*> carry;
  for (const std::string& name : request.carry) carry.push_back(&dataset.array(name));
  ExtractOptions options;
  options.facets = request.facets;
  options.tetrahedra = request.tetrahedra;
  options.values = request.tetrahedra;
  options.strict = request.triangulation == Triangulation::strict;
  options.max_bytes = request.max_bytes;
  options.bricks = aids.bricks;
  options.ordered = aids.ordered;
  options.faces = aids.faces;
  if (!request.terms.empty()) {
    combine_terms(request, dataset, array, carry, aids, layers, task);
    return layers;
  }
  layers.mesh = aids.extractor && !options.strict && !dataset.grid.flat()
                    ? aids.extractor(dataset.grid, array, request.intervals, options, task)
                    : extract_intervals(dataset.grid, array, request.intervals, options, task);
  for (const PointArray* other : carry) layers.carried.push_back({other->name, carry_array(layers.mesh, *other), false});
  return layers;
}

}  // namespace isostrata
