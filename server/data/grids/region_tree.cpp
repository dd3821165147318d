#include "data/grids/region_tree.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace isostrata {
namespace {

constexpr std::int64_t kMostSamples = std::int64_t{1} << 20;

/// Adds the node that cuts `regions` regions, the first of which is `first`, and all below it. cut(axis out, at out, share) says where so much
/// of what is left lies below, and gives what is left on either side.
template <class Cells>
int grow(RegionTree& tree, Cells cells, int first, int regions) {
  if (regions == 1) return ~first;
  const int number = static_cast<int>(tree.nodes.size());
  tree.nodes.emplace_back();
  const int half = regions / 2;
  auto [axis, at, below, above] = cells.cut(half, regions);
  const int under = grow(tree, below, first, half);
  const int over = grow(tree, above, first + half, regions - half);
  tree.nodes[static_cast<std::size_t>(number)] = {axis, at, under, over};
  return number;
}

template <class Cells>
struct Cut {
  int axis = 0;
  double at = 0;
  Cells below, above;
};

/// Cells of a grid of boxes: a range of them along each axis, between planes.
struct BoxCells {
  const std::array<std::vector<double>, 3>* planes;  // [cells + 1] each, rising
  std::array<std::int64_t, 3> first{}, end{};

  Cut<BoxCells> cut(int half, int regions) const {
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (end[a] - first[a] >= end[axis] - first[axis]) axis = a;  // of equal ones that along which a file's values lie farthest apart
    const std::int64_t cells = end[axis] - first[axis];
    std::int64_t middle = first[axis] + (cells * half + regions / 2) / regions;
    if (cells > 1) middle = std::clamp(middle, first[axis] + 1, end[axis] - 1);
    if (cells == 1) middle = end[axis];
    const auto& of = (*planes)[static_cast<std::size_t>(axis)];
    Cut<BoxCells> made{axis, of.empty() ? 0 : of[static_cast<std::size_t>(std::min<std::int64_t>(middle, static_cast<std::int64_t>(of.size()) - 1))], *this, *this};
    made.below.end[static_cast<std::size_t>(axis)] = middle;
    made.above.first[static_cast<std::size_t>(axis)] = middle;
    return made;
  }
};

/// Other cells: their middles.
struct FreeCells {
  std::vector<Vec3d>* middles;
  std::size_t first = 0, end = 0;

  Cut<FreeCells> cut(int half, int regions) const {
    const auto begin = middles->begin();
    Box3d box;
    for (std::size_t i = first; i < end; ++i) box.include((*middles)[i]);
    int axis = 0;
    for (int a = 1; a < 3 && !box.empty(); ++a)
      if (box.upper[a] - box.lower[a] > box.upper[axis] - box.lower[axis]) axis = a;
    const std::size_t middle = first + (end - first) * static_cast<std::size_t>(half) / static_cast<std::size_t>(regions);
    double at = 0;
    if (first < end) {
      const auto less = [axis](const Vec3d& a, const Vec3d& b) { return a[axis] < b[axis]; };
      const auto place = begin + static_cast<std::ptrdiff_t>(std::min(middle, end - 1));
      std::nth_element(begin + static_cast<std::ptrdiff_t>(first), place, begin + static_cast<std::ptrdiff_t>(end), less);
      at = (*place)[axis];
      if (middle > first) {
        const double before = (*std::max_element(begin + static_cast<std::ptrdiff_t>(first), place, less))[axis];
        at = before + (at - before) / 2;
      }
    }
    return {axis, at, {middles, first, middle}, {middles, middle, end}};
  }
};

std::array<std::vector<double>, 3> planes_of(const Grid& grid) {
  std::array<std::vector<double>, 3> planes;
  const auto dims = grid.dims();
  for (int axis = 0; axis < 3; ++axis) {
    std::int64_t stride = 1;
    for (int a = 0; a < axis; ++a) stride *= dims[static_cast<std::size_t>(a)];
    for (std::int64_t i = 0; i < dims[static_cast<std::size_t>(axis)]; ++i)
      planes[static_cast<std::size_t>(axis)].push_back(grid.point(i * stride)[axis]);
    auto& of = planes[static_cast<std::size_t>(axis)];
    std::sort(of.begin(), of.end());  // an axis may fall
  }
  return planes;
}

template <class NearSide>
void walk(const RegionTree& tree, int child, const NearSide& below_first, std::vector<int>& order) {
  if (child < 0) return order.push_back(~child);
  const RegionTree::Node& node = tree.nodes[static_cast<std::size_t>(child)];
  const bool below = below_first(node);
  walk(tree, below ? node.below : node.above, below_first, order);
  walk(tree, below ? node.above : node.below, below_first, order);
}

bool narrow(const RegionTree& tree, int child, int region, Box3d& box) {
  if (child < 0) return ~child == region;
  const RegionTree::Node& node = tree.nodes[static_cast<std::size_t>(child)];
  Box3d below = box, above = box;
  below.upper[node.axis] = std::min(below.upper[node.axis], node.at);
  above.lower[node.axis] = std::max(above.lower[node.axis], node.at);
  if (narrow(tree, node.below, region, below)) return box = below, true;
  if (narrow(tree, node.above, region, above)) return box = above, true;
  return false;
}

int root_of(const RegionTree& tree) { return tree.nodes.empty() ? ~0 : 0; }

}  // namespace

int region_count(const RegionTree& tree) { return static_cast<int>(tree.nodes.size()) + 1; }

int region_at(const RegionTree& tree, const Vec3d& point) {
  int child = root_of(tree);
  while (child >= 0) {
    const RegionTree::Node& node = tree.nodes[static_cast<std::size_t>(child)];
    child = point[node.axis] < node.at ? node.below : node.above;
  }
  return ~child;
}

Box3d region_box(const RegionTree& tree, int region) {
  constexpr double far = std::numeric_limits<double>::infinity();
  Box3d box;
  box.lower = {-far, -far, -far};
  box.upper = {far, far, far};
  narrow(tree, root_of(tree), region, box);
  return box;
}

std::vector<int> front_to_back(const RegionTree& tree, const Vec3d& eye) {
  std::vector<int> order;
  walk(tree, root_of(tree), [&](const RegionTree::Node& node) { return eye[node.axis] < node.at; }, order);
  return order;
}

std::vector<int> front_to_back_along(const RegionTree& tree, const Vec3d& direction) {
  std::vector<int> order;
  walk(tree, root_of(tree), [&](const RegionTree::Node& node) { return direction[node.axis] > 0; }, order);
  return order;
}

RegionTree make_regions(const Grid& grid, int regions) {
  RegionTree tree;
  if (grid.rectilinear()) {
    const auto planes = planes_of(grid);
    BoxCells all{&planes};
    for (std::size_t a = 0; a < 3; ++a) all.end[a] = std::max<std::int64_t>(static_cast<std::int64_t>(planes[a].size()) - 1, 0);
    grow(tree, all, 0, regions);
    return tree;
  }
  const std::int64_t cells = grid.cell_count(), stride = cells / kMostSamples + 1;
  std::vector<Vec3d> middles;
  middles.reserve(static_cast<std::size_t>(cells / stride + 1));
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::int64_t cell = 0; cell < cells; cell += stride) {
    const int count = grid.cell_points(cell, ids);
    Box3d box;
    for (int v = 0; v < count; ++v) box.include(grid.point(ids[static_cast<std::size_t>(v)]));
    middles.push_back((box.lower + box.upper) * 0.5);
  }
  grow(tree, FreeCells{&middles, 0, middles.size()}, 0, regions);
  return tree;
}

}  // namespace isostrata
