#include "data/derived/scaled_dataset.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/parallel.h"

namespace isostrata {
namespace {

/// In place of `points`, and kept alive by `storage` beside what that keeps.
void scale_points(PointSpan& points, std::shared_ptr<const void>& storage, Vec3d factors) {
  std::visit(
      [&](auto from) {
        using Point = std::remove_const_t<typename decltype(from)::element_type>;
        using Coordinate = decltype(Point::x);
        struct Kept {
          std::shared_ptr<const void> before;
          std::vector<Point> points;
        };
        auto kept = std::make_shared<Kept>(Kept{storage, std::vector<Point>(from.size())});
        parallel_for(std::ssize(from), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i) {
            const auto at = static_cast<std::size_t>(i);
            for (int axis = 0; axis < 3; ++axis) kept->points[at][axis] = static_cast<Coordinate>(static_cast<double>(from[at][axis]) * factors[axis]);
          }
        });
        points = std::span<const Point>(kept->points);
        storage = std::move(kept);
      },
      points);
}

Grid scaled_grid(const Grid& grid, Vec3d factors) {
  Grid out = grid;
  if (auto* uniform = std::get_if<UniformGrid>(&out.shape)) {
    uniform->origin = scaled(uniform->origin, factors);
    uniform->spacing = scaled(uniform->spacing, factors);
  } else if (auto* rectilinear = std::get_if<RectilinearGrid>(&out.shape)) {
    for (int axis = 0; axis < 3; ++axis)
      for (double& place : rectilinear->axes[static_cast<std::size_t>(axis)]) place *= factors[axis];
  } else if (auto* curvilinear = std::get_if<CurvilinearGrid>(&out.shape)) {
    scale_points(curvilinear->points, out.storage, factors);
  } else if (auto* unstructured = std::get_if<UnstructuredGrid>(&out.shape)) {
    scale_points(unstructured->points, out.storage, factors);
  }
  return out;
}

Dataset with_grid(const Dataset& dataset, Grid grid, Vec3d factors) {
  Dataset out = dataset;
  out.grid = std::move(grid);
  out.bounds = scaled(out.bounds, factors);
  if (!out.whole) return out;
  auto whole = std::make_shared<WholeOfPart>(*out.whole);
  whole->regions = scaled_regions(whole->regions, factors);
  out.whole = std::move(whole);
  return out;
}

template <class Of>
std::shared_ptr<Of> find_made(std::map<std::pair<const void*, std::tuple<double, double, double>>, std::weak_ptr<Of>>& made, const void* original,
                              const std::tuple<double, double, double>& factors) {
  std::erase_if(made, [](const auto& of) { return of.second.expired(); });
  const auto it = made.find({original, factors});
  return it == made.end() ? nullptr : it->second.lock();
}

}  // namespace

Dataset scaled_dataset(const Dataset& dataset, Vec3d axis_scale) { return with_grid(dataset, scaled_grid(dataset.grid, axis_scale), axis_scale); }

RegionTree scaled_regions(RegionTree regions, Vec3d axis_scale) {
  for (RegionTree::Node& node : regions.nodes) node.at *= axis_scale[node.axis];
  return regions;
}

std::shared_ptr<const Dataset> ScaledDatasets::scaled(const std::shared_ptr<const Dataset>& dataset, Vec3d axis_scale) {
  if (axis_scale == Vec3d{1, 1, 1}) return dataset;
  const Factors factors{axis_scale.x, axis_scale.y, axis_scale.z};
  const void* mesh = dataset->grid.rectilinear() ? nullptr : dataset->grid.storage.get();
  std::unique_lock lock(mutex_);
  if (auto made = find_made(datasets_, dataset.get(), factors)) return made;
  std::shared_ptr<const Grid> grid = mesh ? find_made(meshes_, mesh, factors) : nullptr;
  if (!grid) {
    lock.unlock();  // others go on while points are copied
    auto own = std::make_shared<const Grid>(scaled_grid(dataset->grid, axis_scale));
    lock.lock();
    if (auto made = find_made(datasets_, dataset.get(), factors)) return made;
    grid = mesh ? find_made(meshes_, mesh, factors) : nullptr;
    if (!grid) grid = std::move(own);
    if (mesh) meshes_[{mesh, factors}] = grid;
  }
  struct Made {
    std::shared_ptr<const Dataset> original;
    std::shared_ptr<const Grid> grid;
    Dataset dataset;
  };
  const auto made = std::make_shared<const Made>(Made{dataset, grid, with_grid(*dataset, *grid, axis_scale)});
  std::shared_ptr<const Dataset> out(made, &made->dataset);
  datasets_[{dataset.get(), factors}] = out;
  return out;
}

}  // namespace isostrata
