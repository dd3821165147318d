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

/// Across the ray and along it.
class RayFrame {
 public:
  explicit RayFrame(const ViewRay& ray) : ray_(ray) {
    const Vec3d d = ray.direction;
    const Vec3d other = std::abs(d.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    across_ = normalized(cross(d, other));
    upward_ = cross(d, across_);
  }

  /// From the ray's origin: to two sides, and along it.
  Vec3d place(Vec3d p) const {
    const Vec3d from = p - ray_.origin;
    return {dot(from, across_), dot(from, upward_), dot(from, ray_.direction)};
  }
  /// On which sides of the ray a point lies: a bit for each of left, right, below and above; on the ray, to rounding, for both. None of one that is not
  /// finite. A cell that the ray meets has points on all sides.
  std::uint8_t sides(Vec3d p) const {
    const Vec3d at = place(p);
    const double slack = rounding(at.z);
    return static_cast<std::uint8_t>((at.x <= slack ? 1 : 0) | (at.x >= -slack ? 2 : 0) | (at.y <= slack ? 4 : 0) | (at.y >= -slack ? 8 : 0));
  }
  bool reaches(double least, double most) const {
    return most >= ray_.first - rounding(most) && least <= ray_.last + rounding(least);
  }

 private:
  /// What is rounded away grows with the distance to the eye.
  static double rounding(double along) { return 1e-12 * std::abs(along); }

  const ViewRay& ray_;
  Vec3d across_, upward_;
};
constexpr std::uint8_t kAllSides = 15;

void add_sides(const Grid& grid, const RayFrame& frame, std::vector<std::uint8_t>& sides, const Task& task) {
  const auto add = [&](const auto& point) {
    parallel_for(static_cast<std::int64_t>(sides.size()), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
      task.check();
      for (std::int64_t p = begin; p < end; ++p) sides[static_cast<std::size_t>(p)] |= frame.sides(point(p));
    });
  };
  const auto add_stored = [&](const PointSpan& points) {
    std::visit(
        [&](auto span) {
          add([span](std::int64_t id) {
            const auto& p = span[static_cast<std::size_t>(id)];
            return Vec3d{p.x, p.y, p.z};
          });
        },
        points);
  };
  if (const auto* bent = std::get_if<CurvilinearGrid>(&grid.shape))
    add_stored(bent->points);
  else if (const auto* free = std::get_if<UnstructuredGrid>(&grid.shape))
    add_stored(free->points);
  else
    add([&grid](std::int64_t id) { return grid.point(id); });
}

/// Calls found(cell) for each cell of a row of a structured grid with points on all sides.
template <class Found>
void look_at_row(const std::array<std::int64_t, 3>& dims, const std::vector<std::uint8_t>& sides, std::int64_t row, const Found& found) {
  const std::int64_t cells_x = std::max<std::int64_t>(dims[0] - 1, 1), cells_y = std::max<std::int64_t>(dims[1] - 1, 1);
  const std::int64_t dx = dims[0] > 1 ? 1 : 0, dy = dims[1] > 1 ? dims[0] : 0, dz = dims[2] > 1 ? dims[0] * dims[1] : 0;
  const std::uint8_t* const at = sides.data() + dims[0] * (row % cells_y + dims[1] * (row / cells_y));
  for (std::int64_t i = 0; i < cells_x; ++i) {
    const std::uint8_t* const p = at + i;
    const int all = p[0] | p[dy] | p[dz] | p[dy + dz] | p[dx] | p[dx + dy] | p[dx + dz] | p[dx + dy + dz];
    if (all == kAllSides) found(row * cells_x + i);
  }
}

template <class Found>
void look_at_cells(const UnstructuredGrid& grid, const std::vector<std::uint8_t>& sides, std::int64_t begin, std::int64_t end, const Found& found) {
  for (std::int64_t cell = begin; cell < end; ++cell) {
    const auto first = static_cast<std::size_t>(grid.offsets[static_cast<std::size_t>(cell)]), last = static_cast<std::size_t>(grid.offsets[static_cast<std::size_t>(cell) + 1]);
    int all = 0;
    for (std::size_t v = first; v < last; ++v) all |= sides[static_cast<std::size_t>(grid.connectivity[v])];
    if (all == kAllSides) found(cell);
  }
}

/// grids: of the same cells; each point is in each of its places.
std::vector<std::int64_t> look_at_each(std::span<const Grid* const> grids, const ViewRay& ray, const Task& task) {
  const RayFrame frame(ray);
  const Grid& grid = *grids.front();
  std::vector<std::uint8_t> sides(static_cast<std::size_t>(grid.point_count()));
  for (const Grid* of : grids) add_sides(*of, frame, sides, task);
  const auto along_ray = [&](std::int64_t cell) {
    std::array<std::int64_t, kMaxCellVertices> ids;
    const int count = grid.cell_points(cell, ids);
    Box3d box;
    for (const Grid* of : grids)
      for (int v = 0; v < count; ++v) box.include(frame.place(of->point(ids[static_cast<std::size_t>(v)])));
    return frame.reaches(box.lower.z, box.upper.z);
  };
  std::mutex mutex;  // guards `found`
  std::vector<std::int64_t> found;
  const auto* const free = std::get_if<UnstructuredGrid>(&grid.shape);
  const auto dims = free ? std::array<std::int64_t, 3>{} : grid.dims();
  const std::int64_t rows = free ? grid.cell_count() : grid.cell_count() / std::max<std::int64_t>(dims[0] - 1, 1);
  parallel_for(rows, free ? 1 << 15 : 256, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    std::vector<std::int64_t> here;
    const auto take = [&](std::int64_t cell) {
      if (!grid.hidden(cell) && along_ray(cell)) here.push_back(cell);
    };
    if (free)
      look_at_cells(*free, sides, begin, end, take);
    else
      for (std::int64_t row = begin; row < end; ++row) look_at_row(dims, sides, row, take);
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
  const Grid* const one = &grid;
  return look_at_each(std::span(&one, 1), ray, task);
}

std::vector<std::int64_t> ray_cells(const Grid& first, const Grid& second, const ViewRay& ray, const Task& task) {
  if (first.cell_count() == 0 || !(ray.first <= ray.last)) return {};
  const std::array<const Grid*, 2> both{&first, &second};
  return look_at_each(both, ray, task);
}

}  // namespace isostrata
