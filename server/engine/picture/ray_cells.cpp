#include "engine/picture/ray_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <utility>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr double kSlack = 1e-9;  // of the grid's size: what is rounded away must not lose a cell

/// Walks the boxes axis by axis: a slab of the first axis leaves a part of the ray, which meets few slabs of the next.
class BoxWalk {
 public:
  BoxWalk(const Grid& grid, const ViewRay& ray) : grid_(grid), ray_(ray), dims_(grid.dims()) {
    std::int64_t stride = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::int64_t i = 0; i < dims_[axis]; ++i) planes_[axis].push_back(grid.point(i * stride)[static_cast<int>(axis)]);
      stride *= dims_[axis];
      cells_[axis] = std::max<std::int64_t>(dims_[axis] - 1, 1);
      slack_ = std::max(slack_, kSlack * std::abs(planes_[axis].back() - planes_[axis].front()));
    }
    std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return along(a) > along(b); });
  }

  std::vector<std::int64_t> cells() {
    walk(0, ray_.first, ray_.last);
    std::sort(found_.begin(), found_.end());
    return std::move(found_);
  }

 private:
  double along(std::size_t axis) const { return std::abs(ray_.direction[static_cast<int>(axis)]); }

  /// The ends of slab i, the lower one first.
  std::pair<double, double> slab(std::size_t axis, std::int64_t i) const {
    const auto& planes = planes_[axis];
    const double a = planes[static_cast<std::size_t>(i)], b = planes[std::min(static_cast<std::size_t>(i) + 1, planes.size() - 1)];
    return {std::min(a, b) - slack_, std::max(a, b) + slack_};
  }

  /// What lies between the planes of [first, last], a part of the ray.
  bool limit(std::size_t axis, double lower, double upper, double& first, double& last) const {
    const double origin = ray_.origin[static_cast<int>(axis)], direction = ray_.direction[static_cast<int>(axis)];
    if (direction == 0) return lower <= origin && origin <= upper;
    const double a = (lower - origin) / direction, b = (upper - origin) / direction;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
    return first <= last;
  }

  void walk(std::size_t depth, double first, double last) {
    const std::size_t axis = order_[depth];
    const bool falls = planes_[axis].back() < planes_[axis].front();
    const std::int64_t cells = cells_[axis];
    double begin = first, end = last;
    const double least = slab(axis, falls ? cells - 1 : 0).first, most = slab(axis, falls ? 0 : cells - 1).second;
    if (!limit(axis, least, most, begin, end)) return;
    const double origin = ray_.origin[static_cast<int>(axis)], direction = ray_.direction[static_cast<int>(axis)];
    const double from = direction == 0 ? origin : origin + direction * begin, to = direction == 0 ? origin : origin + direction * end;
    // Slabs by rising place: s is the s-th from below.
    const auto number = [&](std::int64_t s) { return falls ? cells - 1 - s : s; };
    for (std::int64_t s = first_reaching(axis, cells, std::min(from, to), number); s < cells; ++s) {
      const auto [lower, upper] = slab(axis, number(s));
      if (lower > std::max(from, to)) break;
      double part_first = begin, part_last = end;
      if (!limit(axis, lower, upper, part_first, part_last)) continue;
      index_[axis] = number(s);
      if (depth < 2)
        walk(depth + 1, part_first, part_last);
      else
        take();
    }
  }

  template <class Number>
  std::int64_t first_reaching(std::size_t axis, std::int64_t cells, double place, const Number& number) const {
    std::int64_t low = 0, high = cells;
    while (low < high) {
      const std::int64_t middle = low + (high - low) / 2;
      if (slab(axis, number(middle)).second < place)
        low = middle + 1;
      else
        high = middle;
    }
    return low;
  }

  void take() {
    const std::int64_t cell = index_[0] + cells_[0] * (index_[1] + cells_[1] * index_[2]);
    if (!grid_.hidden(cell)) found_.push_back(cell);
  }

  const Grid& grid_;
  const ViewRay& ray_;
  const std::array<std::int64_t, 3> dims_;
  std::array<std::vector<double>, 3> planes_;
  std::array<std::int64_t, 3> cells_{}, index_{};
  std::array<std::size_t, 3> order_{0, 1, 2};
  double slack_ = 0;
  std::vector<std::int64_t> found_;
};

/// Across the ray and along it: a cell that the ray meets has 0 between its least and its greatest place across, both ways.
class RayFrame {
 public:
  explicit RayFrame(const ViewRay& ray) : ray_(ray) {
    const Vec3d d = ray.direction;
    const Vec3d other = std::abs(d.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    across_ = normalized(cross(d, other));
    upward_ = cross(d, across_);
  }

  /// In this frame, from the ray's origin.
  Vec3d place(Vec3d p) const {
    const Vec3d from = p - ray_.origin;
    return {dot(from, across_), dot(from, upward_), dot(from, ray_.direction)};
  }
  /// slack: world units.
  bool meets(const Box3d& box, double slack) const {
    return box.lower.x <= slack && box.upper.x >= -slack && box.lower.y <= slack && box.upper.y >= -slack && box.upper.z >= ray_.first - slack &&
           box.lower.z <= ray_.last + slack;
  }

 private:
  const ViewRay& ray_;
  Vec3d across_, upward_;
};

/// include(box, id): puts the places of a point into the box.
template <class Include>
std::vector<std::int64_t> look_at_each(const Grid& grid, const RayFrame& frame, const Include& include, const Task& task) {
  std::mutex mutex;  // guards `found`
  std::vector<std::int64_t> found;
  parallel_for(grid.cell_count(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    std::vector<std::int64_t> here;
    std::array<std::int64_t, kMaxCellVertices> ids;
    for (std::int64_t cell = begin; cell < end; ++cell) {
      if (grid.hidden(cell)) continue;
      const int count = grid.cell_points(cell, ids);
      Box3d box;
      for (int v = 0; v < count; ++v) include(box, ids[static_cast<std::size_t>(v)]);
      // What is rounded away grows with the distance to the eye.
      const double slack = 1e-12 * std::max(std::abs(box.lower.z), std::abs(box.upper.z));
      if (frame.meets(box, slack)) here.push_back(cell);
    }
    const std::lock_guard lock(mutex);
    found.insert(found.end(), here.begin(), here.end());
  });
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::vector<std::int64_t> ray_cells(const Grid& grid, const ViewRay& ray, const Task& task) {
  if (grid.cell_count() == 0 || !(ray.first <= ray.last)) return {};
  if (grid.rectilinear()) return BoxWalk(grid, ray).cells();
  const RayFrame frame(ray);
  const auto* bent = std::get_if<CurvilinearGrid>(&grid.shape);
  return std::visit(
      [&](auto points) {
        const auto include = [&](Box3d& box, std::int64_t id) {
          const auto& p = points[static_cast<std::size_t>(id)];
          box.include(frame.place({p.x, p.y, p.z}));
        };
        return look_at_each(grid, frame, include, task);
      },
      bent ? bent->points : std::get<UnstructuredGrid>(grid.shape).points);
}

std::vector<std::int64_t> ray_cells(const Grid& first, const Grid& second, const ViewRay& ray, const Task& task) {
  if (first.cell_count() == 0 || !(ray.first <= ray.last)) return {};
  const RayFrame frame(ray);
  const auto include = [&](Box3d& box, std::int64_t id) {
    box.include(frame.place(first.point(id)));
    box.include(frame.place(second.point(id)));
  };
  return look_at_each(first, frame, include, task);
}

}  // namespace isostrata
