#include "data/derived/proxy_cells.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>

#include "base/buffer.h"
#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr double kUnits = 1ll << 36;              // whole parts of the array's range
constexpr double kPointsAStep = 1.5;              // along each side of a cell
constexpr std::int64_t kMostCellPoints = 40'000'000;  // in all cells, about
constexpr std::int64_t kManyCells = 1'000'000;        // below that all are spread in no time
constexpr std::int64_t kManyCellsAPoint = 3;          // as of tetrahedra: a point's corner is found once, not by each of its cells

/// Sums of whole numbers: their order does not matter.
class Samples {
 public:
  explicit Samples(const ProxyGrid& proxy) : proxy_(proxy), n_(1) {
    for (std::size_t a = 0; a < 3; ++a) {
      n_ *= static_cast<std::size_t>(proxy.dims[a]);
      const double step = proxy.step[static_cast<int>(a)];
      inverse_[static_cast<int>(a)] = step > 0 ? 1 / step : 0;
    }
    sums_ = std::make_unique<std::atomic<std::int64_t>[]>(n_);
    counts_ = std::make_unique<std::atomic<std::int32_t>[]>(n_);
  }

  Vec3d scaled(Vec3d world) const {  // in steps, the first sample's box being [0, 1)
    const Vec3d p = (world - proxy_.corner) / proxy_.scale;
    return {p.x * inverse_.x + 0.5, p.y * inverse_.y + 0.5, p.z * inverse_.z + 0.5};
  }
  std::size_t index(Vec3d at) const {
    std::size_t s = 0;
    for (int a = 2; a >= 0; --a) s = s * static_cast<std::size_t>(proxy_.dims[static_cast<std::size_t>(a)]) + box(at, a);
    return s;
  }
  std::size_t box(Vec3d at, int axis) const {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(at[axis]), 0, proxy_.dims[static_cast<std::size_t>(axis)] - 1));
  }
  void add(Vec3d at, double share) {
    const std::size_t s = index(at);
    if (counts_[s].load(std::memory_order_relaxed) >= (1 << 24)) return;  // the sum stays within its 63 bits
    sums_[s].fetch_add(std::llround(share * kUnits), std::memory_order_relaxed);
    counts_[s].fetch_add(1, std::memory_order_relaxed);
  }
  std::size_t size() const { return n_; }
  std::vector<float> means() const {
    std::vector<float> values(n_, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t s = 0; s < n_; ++s)
      if (const auto count = counts_[s].load(); count > 0)
        values[s] = static_cast<float>(static_cast<double>(sums_[s].load()) / count / kUnits);
    return values;
  }

 private:
  const ProxyGrid& proxy_;
  std::size_t n_;
  Vec3d inverse_;
  std::unique_ptr<std::atomic<std::int64_t>[]> sums_;
  std::unique_ptr<std::atomic<std::int32_t>[]> counts_;
};

struct Corner {
  Vec3d at;  // in steps
  double share = 0;
};
using Corners = std::array<Corner, 8>;  // as a hexahedron's; cells with fewer points repeat some

/// Which points stand for a hexahedron's corners: a wedge, a pyramid and a tetrahedron are hexahedra of which edges are drawn
/// together.
constexpr std::array<int, 8> as_hexahedron(CellType type) {
  switch (type) {
    case CellType::tetrahedron:
      return {0, 1, 2, 2, 3, 3, 3, 3};
    case CellType::pyramid:
      return {0, 1, 2, 3, 4, 4, 4, 4};
    case CellType::wedge:
      return {0, 1, 4, 3, 2, 2, 5, 5};
    case CellType::triangle:
      return {0, 1, 2, 2, 0, 1, 2, 2};
    case CellType::quadrilateral:
      return {0, 1, 2, 3, 0, 1, 2, 3};
    default:
      return {0, 1, 2, 3, 4, 5, 6, 7};
  }
}

double reach_of(Vec3d v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// How many points along u, v and w.
std::array<int, 3> points_along(const Corners& c, std::int64_t most) {
  constexpr std::array<std::array<std::array<int, 2>, 4>, 3> kEdges{
      {{{{0, 1}, {3, 2}, {4, 5}, {7, 6}}}, {{{0, 3}, {1, 2}, {4, 7}, {5, 6}}}, {{{0, 4}, {1, 5}, {2, 6}, {3, 7}}}}};
  std::array<int, 3> n{};
  for (std::size_t a = 0; a < 3; ++a) {
    double longest = 0;
    for (const auto& [from, to] : kEdges[a])
      longest = std::max(longest, reach_of(c[static_cast<std::size_t>(to)].at - c[static_cast<std::size_t>(from)].at));
    n[a] = static_cast<int>(std::clamp(std::ceil(kPointsAStep * longest), 1.0, 2.0 * kMostProxySamples));
  }
  while (static_cast<std::int64_t>(n[0]) * n[1] * n[2] > most) {
    int& largest = *std::max_element(n.begin(), n.end());
    largest = (largest + 1) / 2;
  }
  return n;
}

Corner between(const Corner& a, const Corner& b, double t) { return {lerp(a.at, b.at, t), a.share * (1 - t) + b.share * t}; }

void spread(const Corners& c, std::int64_t most, Samples& samples) {
  const auto n = points_along(c, most);
  for (int i = 0; i < n[0]; ++i) {
    const double u = (i + 0.5) / n[0];
    const std::array<Corner, 4> across{between(c[0], c[1], u), between(c[3], c[2], u), between(c[4], c[5], u),
                                       between(c[7], c[6], u)};
    for (int j = 0; j < n[1]; ++j) {
      const double v = (j + 0.5) / n[1];
      const Corner below = between(across[0], across[1], v), above = between(across[2], across[3], v);
      for (int k = 0; k < n[2]; ++k) {
        const Corner at = between(below, above, (k + 0.5) / n[2]);
        samples.add(at.at, at.share);
      }
    }
  }
}

/// The corners' mean, in an order of its own, so that it does not depend on how the cell is turned... of one point that is all
/// there is to do.
Corner middle(const Corners& c, int points) {
  Corner sum;
  for (int v = 0; v < points; ++v) {
    sum.at = sum.at + c[static_cast<std::size_t>(v)].at;
    sum.share += c[static_cast<std::size_t>(v)].share;
  }
  return {sum.at / static_cast<double>(points), sum.share / points};
}

struct Extent {
  Vec3d low, high;

  Extent(const Corners& own, int points) : low(own[0].at), high(low) {
    for (int v = 1; v < points; ++v) {
      const Vec3d p = own[static_cast<std::size_t>(v)].at;
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
  double reach() const { return reach_of(high - low); }
};

/// The boxes in which a small cell has its middle. A small cell all of whose boxes are among them need not be spread: each gets some cell's middle.
class Middles {
 public:
  explicit Middles(const ProxyGrid& proxy, std::size_t n) : proxy_(proxy), in_(std::make_unique<std::atomic<bool>[]>(n)) {}

  void mark(std::size_t box) { in_[box].store(true, std::memory_order_relaxed); }
  /// In all boxes from that of `low` to that of `high`.
  bool are_in_all(const Samples& samples, Vec3d low, Vec3d high) const {
    const std::size_t nx = static_cast<std::size_t>(proxy_.dims[0]), ny = static_cast<std::size_t>(proxy_.dims[1]);
    for (std::size_t k = samples.box(low, 2); k <= samples.box(high, 2); ++k)
      for (std::size_t j = samples.box(low, 1); j <= samples.box(high, 1); ++j)
        for (std::size_t i = samples.box(low, 0); i <= samples.box(high, 0); ++i)
          if (!in_[i + nx * (j + ny * k)].load(std::memory_order_relaxed)) return false;
    return true;
  }

 private:
  const ProxyGrid& proxy_;
  std::unique_ptr<std::atomic<bool>[]> in_;
};

constexpr Corner kNoCorner{{}, std::numeric_limits<double>::quiet_NaN()};

bool usable(const Corner& corner) { return std::isfinite(reach_of(corner.at)) && std::isfinite(corner.share); }

}  // namespace

std::vector<float> sample_cells(const Grid& grid, const PointArray& array, const ProxyGrid& proxy, std::optional<double> missing, const Task& task) {
  Samples samples(proxy);
  const std::int64_t cells = grid.cell_count();
  const std::int64_t most = std::max<std::int64_t>(64, 4 * kMostCellPoints / std::max<std::int64_t>(cells, 1));
  const double half = array.upper / 2 - array.lower / 2;
  const auto corner_at = [&](std::int64_t id, const auto& values) {
    const auto value = static_cast<double>(values[static_cast<std::size_t>(id)]);
    const Corner corner{samples.scaled(grid.point(id)), (value / 2 - array.lower / 2) / half};
    return usable(corner) && value != missing ? Corner{corner.at, std::clamp(corner.share, 0.0, 1.0)} : kNoCorner;
  };
  Buffer<Corner> corners_of_points;
  if (const std::int64_t points = grid.point_count(); points > 0 && cells / points >= kManyCellsAPoint) {
    corners_of_points.resize(static_cast<std::size_t>(points));
    std::visit(
        [&](auto values) {
          parallel_for(points, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
            task.check();
            for (std::int64_t id = begin; id < end; ++id) corners_of_points[static_cast<std::size_t>(id)] = corner_at(id, values);
          });
        },
        array.values);
  }
  const auto each_cell = [&](const auto& visit) {
    std::visit(
        [&](auto values) {
          parallel_for(cells, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
            task.check();
            std::array<std::int64_t, kMaxCellVertices> ids;
            for (std::int64_t cell = begin; cell < end; ++cell) {
              if (grid.hidden(cell)) continue;
              const int points = grid.cell_points(cell, ids);
              Corners own;
              bool good = points > 0 && points <= 8;
              for (int v = 0; v < points && good; ++v) {
                const std::int64_t id = ids[static_cast<std::size_t>(v)];
                Corner& corner = own[static_cast<std::size_t>(v)];
                corner = corners_of_points.empty() ? corner_at(id, values) : corners_of_points[static_cast<std::size_t>(id)];
                good = !std::isnan(corner.share);
              }
              if (good) visit(cell, own, points, Extent(own, points));
            }
          });
        },
        array.values);
  };
  Middles middles(proxy, samples.size());
  if (cells >= kManyCells)
    each_cell([&](std::int64_t, const Corners& own, int points, const Extent& extent) {
      if (extent.reach() * kPointsAStep <= 2) middles.mark(samples.index(middle(own, points).at));
    });
  each_cell([&](std::int64_t cell, const Corners& own, int points, const Extent& extent) {
    const double along = extent.reach() * kPointsAStep;
    if (along <= 1 || (along <= 2 && cells >= kManyCells && middles.are_in_all(samples, extent.low, extent.high))) {
      const Corner at = middle(own, points);
      samples.add(at.at, at.share);
      return;
    }
    const std::array<int, 8> as = as_hexahedron(grid.cell_type(cell));
    Corners corners;
    for (std::size_t c = 0; c < 8; ++c) corners[c] = own[static_cast<std::size_t>(as[c])];
    spread(corners, most, samples);
  });
  return samples.means();
}

}  // namespace isostrata
