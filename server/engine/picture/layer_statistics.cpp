#include "engine/picture/layer_statistics.h"

#include <algorithm>

#include "data/dataset/array_or_first.h"
#include "engine/picture/layer_request.h"
#include "extraction/measure/components.h"
#include "extraction/measure/measure_layers.h"

namespace isostrata {
namespace {

/// The parts of a layer that is cut in n, which are a mesh's first ones, become its first layer.
void join_parts(IntervalMesh& mesh, std::size_t n) {
  if (n < 2) return;
  const auto joined = [n](std::uint16_t interval) { return static_cast<std::uint16_t>(interval < n ? 0 : interval); };
  for (std::uint16_t& of : mesh.tetrahedron_interval) of = joined(of);
  for (BoundaryFacet& of : mesh.facets) of.interval = joined(of.interval);
}

}  // namespace

LayerStatistics layer_statistics(const StepSource& steps, const Scene& asked, std::uint32_t interval, const std::string& array, std::uint64_t max_bytes, const Task& task) {
  Scene scene = one_moment(asked);
  std::erase_if(scene.intervals, [&](const SceneInterval& of) { return of.id != interval; });
  if (scene.intervals.empty()) throw Error(ErrorCode::not_found, "interval " + std::to_string(interval) + " is not in the scene");
  LayerRequest request = layer_request(scene);
  const auto dataset = steps(scene.step, task);
  if (dataset->whole) throw Error(ErrorCode::unsupported, dataset->name + ": it lies in parts with several processes; a layer's statistics are not summed over parts yet");
  request.array = array_or_first(*dataset, request.array).name;
  const std::string wanted = dataset->array(array.empty() ? request.array : array).name;
  request.carry = {wanted};
  request.facets = true;
  request.normals = request.body_normals = false;
  request.max_bytes = max_bytes;
  Layers layers = extract_layers(request, steps, task);
  const auto size_of = [&](const LayerMeasure& row) { return dataset->grid.flat() ? row.area.domain : row.volume; };
  LayerStatistics out;
  out.array = wanted;
  out.flat = dataset->grid.flat();
  join_parts(layers.mesh, scene.intervals.size());
  const LayerMeasure all = measure_layers(layers.mesh, layers.carried, nullptr, task).front();
  out.volume = size_of(all);
  out.centroid = all.centroid;
  const ArrayMeasure& of = all.of.front();
  out.valued = of.valued;
  out.lower = of.min;
  out.upper = of.max;
  out.mean = of.mean;
  out.standard_deviation = of.deviation;
  const Components pieces = find_components(layers.mesh, task);
  for (const LayerMeasure& piece : measure_layers(layers.mesh, {}, &pieces, task)) {
    if (piece.interval != 0) continue;  // what a term has brought in
    ++out.pieces;
    out.largest = std::max(out.largest, size_of(piece));
  }
  return out;
}

}  // namespace isostrata
