#include "extraction/unstructured/cell_clusters.h"

#include <cmath>
#include <limits>
#include <mutex>
#include <string>

#include "base/error.h"
#include "base/finite.h"
#include "base/parallel.h"
#include "extraction/mesh/partitioned_items.h"
#include "extraction/mesh/passing_array.h"

namespace isostrata {
namespace {

constexpr int kBitsPerAxis = 21;
constexpr int kPartBits = 12;  // the highest bits of the code, by which cells are parted before they are sorted

struct PlacedCell {
  std::uint64_t code;
  std::uint32_t cell;

  bool operator<(const PlacedCell& other) const { return code != other.code ? code < other.code : cell < other.cell; }
};

/// Two zero bits between any two of the lowest 21.
inline std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

Box3d finite_bounds(const Grid& grid, const Task& task) {
  Box3d total;
  std::mutex mutex;  // guards total
  parallel_for(grid.point_count(), 1 << 15, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    Box3d part;
    for (std::int64_t id = begin; id < end; ++id)
      if (const Vec3d p = grid.point(id); is_finite(p)) part.include(p);
    if (part.empty()) return;
    std::lock_guard lock(mutex);
    total.include(part.lower);
    total.include(part.upper);
  });
  return total;
}

/// Where a cell's centroid lies on the curve through the box; at its end if that is nowhere.
class Curve {
 public:
  explicit Curve(const Box3d& box) : lower_(box.lower) {
    constexpr double kSteps = (1 << kBitsPerAxis) - 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double size = box.empty() ? 0 : box.upper[axis] - box.lower[axis];
      scale_[axis] = size > 0 && std::isfinite(size) ? kSteps / size : 0;
    }
  }
  std::uint64_t code(const Vec3d& p) const {
    if (!is_finite(p)) return (std::uint64_t{1} << 3 * kBitsPerAxis) - 1;
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double at = std::clamp((p[axis] - lower_[axis]) * scale_[axis], 0.0, static_cast<double>((1 << kBitsPerAxis) - 1));
      code |= spread(static_cast<std::uint64_t>(at)) << axis;
    }
    return code;
  }

 private:
  Vec3d lower_, scale_;
};

}  // namespace

CellClusters::CellClusters(const Grid& grid, std::uint64_t max_bytes, const Task& task) {
  if (grid.structured())
    throw Error(ErrorCode::invalid_argument,
                "clusters of cells: a " + std::string(grid.kind_name()) + " grid; expected an unstructured one");
  const std::int64_t count = grid.cell_count();
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::too_large, "clusters of cells: " + std::to_string(count) + " cells; expected fewer than 2^32");
  check_budget("the clusters of " + std::to_string(count) + " cells",
               static_cast<std::uint64_t>(count) * (sizeof(PlacedCell) + sizeof(std::uint64_t)), max_bytes);
  task.report(0, "indexing");
  const Curve curve(finite_bounds(grid, task));
  PassingArray<std::uint64_t> codes(static_cast<std::size_t>(count));
  const auto& shape = std::get<UnstructuredGrid>(grid.shape);
  std::visit(
      [&](auto points) {
        parallel_for(count, 1 << 13, [&](std::int64_t begin, std::int64_t end) {
          task.check();
          for (auto cell = static_cast<std::size_t>(begin); cell < static_cast<std::size_t>(end); ++cell) {
            const std::int64_t first = shape.offsets[cell], last = shape.offsets[cell + 1];
            const double share = 1.0 / static_cast<double>(last - first);
            Vec3d sum;
            for (std::int64_t i = first; i < last; ++i) {
              const auto& p = points[static_cast<std::size_t>(shape.connectivity[static_cast<std::size_t>(i)])];
              sum = sum + Vec3d{p.x, p.y, p.z} * share;
            }
            codes[cell] = curve.code(sum);
          }
        });
      },
      shape.points);
  auto parts = partition_items<PlacedCell>(std::int64_t{1} << kPartBits, count, "the clusters of the cells", max_bytes, task,
                                           [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                             for (std::int64_t cell = begin; cell < end; ++cell) {
                                               const PlacedCell at{codes[static_cast<std::size_t>(cell)], static_cast<std::uint32_t>(cell)};
                                               emit(static_cast<std::int64_t>(at.code >> (3 * kBitsPerAxis - kPartBits)), at);
                                             }
                                           });
  codes = PassingArray<std::uint64_t>();
  cells_.resize(static_cast<std::size_t>(count));
  parallel_for(parts.parts(), 8, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t part = begin; part < end; ++part) {
      task.check();
      const auto first = parts.items.begin() + static_cast<std::ptrdiff_t>(parts.first[part]);
      const auto last = parts.items.begin() + static_cast<std::ptrdiff_t>(parts.first[part + 1]);
      std::sort(first, last, [checks = 0, &task](const PlacedCell& a, const PlacedCell& b) mutable {
        if (++checks % (1 << 16) == 0) task.check();  // all cells may be in one part
        return a < b;
      });
      std::transform(first, last, cells_.begin() + (first - parts.items.begin()), [](const PlacedCell& at) { return at.cell; });
    }
  });
}

}  // namespace isostrata
