// Datasets whose axes are drawn longer or shorter than they are.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <tuple>
#include <utility>

#include "data/dataset/dataset.h"

namespace isostrata {

/// The dataset with each of its places times the factors, which are finite and above 0. Values are shared; the points of curvilinear and unstructured
/// grids are copied, in the file's precision. O(points) for those, parallel.
Dataset scaled_dataset(const Dataset& dataset, Vec3d axis_scale);

/// The planes between its regions, too.
RegionTree scaled_regions(RegionTree regions, Vec3d axis_scale);

/// Scaled datasets, one of each for as long as somebody holds it. Steps on one mesh stay on one mesh. Any thread. Lock: mutex_, not held while points are copied.
class ScaledDatasets {
 public:
  /// `dataset` itself if all factors are 1.
  std::shared_ptr<const Dataset> scaled(const std::shared_ptr<const Dataset>& dataset, Vec3d axis_scale);

 private:
  using Factors = std::tuple<double, double, double>;
  template <class Of>
  using Made = std::map<std::pair<const void*, Factors>, std::weak_ptr<Of>>;

  std::mutex mutex_;
  Made<const Dataset> datasets_;  // by the original, which lives as long as what was made of it
  Made<const Grid> meshes_;       // by the original's Grid::storage, likewise
};

}  // namespace isostrata
