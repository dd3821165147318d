// What a line meets of a scene's layers, with the values of arrays there: the cells that it may meet are cut by themselves, as pictures cut all of them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "extraction/layers/extract_layers.h"
#include "rendering/picture/view_ray.h"
#include "scene/scene.h"

namespace isostrata {

/// One step or time of a scene (of a smear the first), along one ray. Both must outlive it. Any thread, one at a time.
class RayLayers {
 public:
  /// array: by which layers are cut; empty: the scene's. Throws what `steps` throws; unsupported (a part of a dataset that others hold the rest of); not_found.
  RayLayers(const StepSource& source, const Scene& scene, const ViewRay& ray, const Task& task, const std::string& array = "");

  /// As the scene asks; it may be changed until extract(). Nothing is carried.
  LayerRequest request;

  /// Cuts the layers of request. Throws what extract_layers throws.
  void extract();

  /// One or two, as the time is made of.
  const std::vector<std::shared_ptr<const Dataset>>& steps() const { return steps_; }
  /// At a time between steps an array that the other step has not has no value.
  bool has_array(const std::string& name) const;
  bool met_cells() const { return !cells_.empty(); }
  const Layers& layers() const { return layers_; }

  /// The cell of the file that the tetrahedron (of a flat grid the facet) was cut out of; -1: not known by that.
  std::int64_t cell_of(std::size_t item) const;
  /// Cells, rising, among which is each that another ray meets, of all of the steps at some time between them.
  std::vector<std::int64_t> cells_on(const ViewRay& ray) const;

  /// What a carried array has in the tetrahedron, or of a flat grid the facet, where its corners count so much. Nothing if that is not finite. In double precision.
  std::optional<double> value(const std::string& name, std::size_t item, std::span<const std::uint32_t> corners, std::span<const double> weights) const;

 private:
  bool around_points() const;
  std::int64_t run_of(std::size_t item) const;

  const ViewRay& ray_;
  const Task& task_;
  std::vector<std::shared_ptr<const Dataset>> steps_;
  std::vector<std::int64_t> cells_;  // that those of layers_.dataset are, or are cut from
  Layers layers_;
};

/// All of the field of an array, in one layer that has all its values and carries them, at the scene's time: its terms and ends are left out. Whole values only of
/// the scene's own array. Not extracted yet. array: empty: the scene's. Throws as RayLayers; not_found (a step has not this array).
RayLayers whole_field(const StepSource& source, const Scene& scene, const ViewRay& ray, const std::string& array, const Task& task);

/// What the file has on the cells of this array; null if it has it on points.
const CellValues* cells_of_array(const Dataset& dataset, const std::string& name);
double value_of(const CellValues& cells, std::int64_t cell);

}  // namespace isostrata
